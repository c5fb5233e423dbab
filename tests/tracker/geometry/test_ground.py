"""Back-projection through the road (eq. 2) and its Jacobian."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tracker.geometry import road_contact, road_contact_jacobian
from tracker.types import Camera

K = np.array([[700.0, 0.0, 600.0], [0.0, 710.0, 170.0], [0.0, 0.0, 1.0]])
pixels_below_horizon = st.tuples(st.floats(0, 1200), st.floats(200, 370))
pitches, rolls, heights = st.floats(-0.02, 0.02), st.floats(-0.03, 0.03), st.floats(0.5, 3.0)


def contact_of(pixel: np.ndarray, camera: Camera) -> np.ndarray:
    return road_contact(camera.rays(pixel), camera.road_normal, camera.height)


def test_a_level_camera_sees_the_road_at_f_h_over_v() -> None:
    camera = Camera.mounted(K, (1200, 370), height=1.5)
    contact = contact_of(np.array([[600.0, 170.0 + 71.0]]), camera)
    np.testing.assert_allclose(contact, [[0.0, 1.5, 15.0]], atol=1e-12)


def test_rays_at_and_above_the_horizon_give_nan() -> None:
    camera = Camera.mounted(K, (1200, 370), height=1.5)
    contact = contact_of(np.array([[600.0, 170.0], [100.0, 20.0], [600.0, 300.0]]), camera)
    assert np.isnan(contact[:2]).all()
    assert np.isfinite(contact[2]).all()


def test_a_camera_that_looks_up_sees_the_same_pixel_further_away() -> None:
    pixel = np.array([[600.0, 260.0]])
    level = contact_of(pixel, Camera.mounted(K, (1200, 370), 1.5))
    up = contact_of(pixel, Camera.mounted(K, (1200, 370), 1.5, pitch=0.01))
    assert up[0, 2] > level[0, 2]


@given(pixels_below_horizon, heights, pitches, rolls)
def test_contacts_lie_on_the_road_and_project_back(pixel, height, pitch, roll) -> None:
    camera = Camera.mounted(K, (1200, 370), height, pitch, roll)
    contact = contact_of(np.array([pixel]), camera)
    if np.isnan(contact).any():
        return
    np.testing.assert_allclose(contact @ camera.road_normal, [height], rtol=1e-9)
    np.testing.assert_allclose(camera.project(contact), [pixel], atol=1e-6)


@given(pixels_below_horizon, heights, pitches, rolls)
def test_jacobian_equals_central_differences(pixel, height, pitch, roll) -> None:
    camera = Camera.mounted(K, (1200, 370), height, pitch, roll)
    pixels = np.array([pixel])
    jacobian = road_contact_jacobian(
        camera.rays(pixels), camera.K_inverse, camera.road_normal, camera.height
    )
    if np.isnan(jacobian).any() or contact_of(pixels, camera)[0, 2] > 200:
        return
    step = 1e-5
    for column, nudge in enumerate(np.eye(4) * step):
        ends = [
            contact_of(
                pixels + sign * nudge[:2],
                nodded(camera, sign * nudge[3], height + sign * nudge[2]),
            )
            for sign in (1.0, -1.0)
        ]
        numeric = (ends[0] - ends[1])[0] / (2 * step)
        np.testing.assert_allclose(jacobian[0, :, column], numeric, rtol=2e-3, atol=1e-4)


def nodded(camera: Camera, pitch: float, height: float) -> Camera:
    """The camera turned up about its own x axis, at another height."""
    T = camera.T_cam_road.copy()
    c, s = np.cos(pitch), np.sin(pitch)
    T[:3, :3] = np.array([[1, 0, 0], [0, c, s], [0, -s, c]]) @ T[:3, :3]
    T[:3, 3] = T[:3, 1] * height
    return Camera(camera.K, camera.image_size, T)


def test_no_pixels_have_no_contacts() -> None:
    camera = Camera.mounted(K, (1200, 370), 1.5)
    rays = camera.rays(np.zeros((0, 2)))
    assert road_contact(rays, camera.road_normal, 1.5).shape == (0, 3)
    assert road_contact_jacobian(rays, camera.K_inverse, camera.road_normal, 1.5).shape == (0, 3, 4)

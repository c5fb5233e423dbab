"""Back-projection through the road (eq. 2) and its Jacobian, in the road's axes."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from tests.tracker.kernels.plain_tracks import road_contact_jacobian
from tracker.geometry import road_contact, rotation_x, transform
from tracker.types import Camera

K = np.array([[700.0, 0.0, 600.0], [0.0, 710.0, 170.0], [0.0, 0.0, 1.0]])
pixels_below_horizon = st.tuples(st.floats(0, 1200), st.floats(210, 370))
pitches, rolls, heights = st.floats(-0.02, 0.02), st.floats(-0.03, 0.03), st.floats(0.5, 3.0)


def mounted(height: float = 1.5, pitch: float = 0.0, roll: float = 0.0) -> Camera:
    return Camera.mounted(K, (1200, 370), height, pitch, roll)


def test_a_level_camera_sees_the_road_at_f_h_over_v() -> None:
    rays = mounted().rays_road(np.array([[600.0, 170.0 + 71.0], [600.0 + 70.0, 170.0 + 71.0]]))
    contact = road_contact(rays, 1.5)
    np.testing.assert_allclose(contact, [[0.0, 1.5, 15.0], [1.5, 1.5, 15.0]], atol=1e-12)


def test_rays_at_and_above_the_horizon_give_nan() -> None:
    rays = mounted().rays_road(np.array([[600.0, 170.0], [100.0, 20.0], [600.0, 300.0]]))
    contact = road_contact(rays, 1.5)
    assert np.isnan(contact[:2]).all()
    assert np.isfinite(contact[2]).all()
    jacobian = road_contact_jacobian(rays, contact, mounted().A_road_pixel[:, :2])
    assert np.isnan(jacobian[:2]).all()
    assert np.isfinite(jacobian[2]).all()


def test_a_camera_that_looks_up_sees_the_same_pixel_further_away() -> None:
    pixel = np.array([[600.0, 260.0]])
    level = road_contact(mounted().rays_road(pixel), 1.5)
    up = road_contact(mounted(pitch=0.01).rays_road(pixel), 1.5)
    assert up[0, 2] > level[0, 2]


@given(pixels_below_horizon, heights, pitches, rolls)
def test_contacts_lie_on_the_road_and_project_back(pixel, height, pitch, roll) -> None:
    camera = mounted(height, pitch, roll)
    contact_cam = camera.touch_road(np.array([pixel]))
    assume(np.isfinite(contact_cam).all())
    np.testing.assert_allclose(contact_cam @ camera.road_normal, [height], rtol=1e-9)
    np.testing.assert_allclose(camera.project(contact_cam), [pixel], atol=1e-6)
    from_the_camera = road_contact(camera.rays_road(np.array([pixel])), height)
    on_the_road = transform(camera.T_road_cam, contact_cam)
    np.testing.assert_allclose(from_the_camera - [0.0, height, 0.0], on_the_road, atol=1e-6)


def test_the_jacobian_of_a_point_ahead_is_the_one_of_the_textbook() -> None:
    # Z = f h / v: dZ/dv = -Z^2 / (f h), dX/du = Z / f, dZ/dh = Z / h, dZ/dpitch = (Z^2 + h^2) / h.
    rays = mounted().rays_road(np.array([[600.0, 241.0]]))  # Z = 15, X = 0
    contact = road_contact(rays, 1.5)
    jacobian = road_contact_jacobian(rays, contact, mounted().A_road_pixel[:, :2])
    by_hand = [
        [15 / 700, 0.0, 0.0, 0.0],
        [0.0, -(15.0**2) / (710 * 1.5), 10.0, (15.0**2 + 1.5**2) / 1.5],
    ]
    np.testing.assert_allclose(jacobian[0], by_hand, atol=1e-12)


@given(pixels_below_horizon, heights, pitches, rolls)
def test_the_jacobian_equals_central_differences(pixel, height, pitch, roll) -> None:
    """By pixel, height, and pitch about the road's own x axis: a nod of the car that carries it."""
    camera, pixels = mounted(height, pitch, roll), np.array([pixel])
    rays = camera.rays_road(pixels)
    contact = road_contact(rays, height)
    assume(np.isfinite(contact).all() and contact[0, 2] < 150)
    jacobian = road_contact_jacobian(rays, contact, camera.A_road_pixel[:, :2])

    def xz(du: float, dv: float, d_height: float, d_pitch: float) -> np.ndarray:
        moved = camera.rays_road(pixels + np.array([du, dv])) @ rotation_x(d_pitch).T
        return road_contact(moved, height + d_height)[0, ::2]

    step = 1e-5
    for column, nudge in enumerate(np.eye(4) * step):
        numeric = (xz(*nudge) - xz(*-nudge)) / (2 * step)
        np.testing.assert_allclose(jacobian[0, :, column], numeric, rtol=1e-4, atol=1e-4)


def test_the_pitch_of_the_jacobian_is_the_pitch_of_a_mounted_camera() -> None:
    pixels, step = np.array([[400.0, 250.0], [900.0, 330.0]]), 1e-6
    ends = [road_contact(mounted(pitch=p).rays_road(pixels), 1.5) for p in (step, -step)]
    numeric = (ends[0] - ends[1])[:, ::2] / (2 * step)
    camera = mounted()
    rays = camera.rays_road(pixels)
    jacobian = road_contact_jacobian(rays, road_contact(rays, 1.5), camera.A_road_pixel[:, :2])
    np.testing.assert_allclose(jacobian[:, :, 3], numeric, rtol=1e-6)


@pytest.mark.parametrize("height", [0.8, 1.65])
def test_no_rays_have_no_contacts(height: float) -> None:
    rays = mounted().rays_road(np.zeros((0, 2)))
    contact = road_contact(rays, height)
    assert contact.shape == (0, 3)
    d_rays = mounted().A_road_pixel[:, :2]
    assert road_contact_jacobian(rays, contact, d_rays).shape == (0, 2, 4)

"""What looks make of frames: seeded, each knob does what it says, labels stay as they are."""

from functools import cache

import cv2
import numpy as np
import pytest

from mot_sim.simulation.camera_looks import (
    CAMERA_LOOKS,
    PLAIN,
    develop,
    developing,
    find_camera_look,
)
from mot_sim.simulation.camera_looks.look import CameraLook, Exposure, File, Lens, Sensor, Tone
from mot_sim.simulation.episode import record
from mot_sim.simulation.imaging import RenderedImages
from mot_sim.simulation.registry import find_scene
from mot_sim.simulation.renderers import find_renderer
from mot_sim.simulation.scene import Rollout
from tests.mot_sim.simulation.kernels.test_drawing import SMALL
from tests.mot_sim.simulation.scenery.test_post_processing import drawn, street

KITTI = find_camera_look("kitti")
WEIGHTS = np.array([0.299, 0.587, 0.114])


@cache
def picture() -> np.ndarray:
    """A small picture of everything from dark to bright, in many colours."""
    rng = np.random.default_rng(3)
    coarse = rng.integers(0, 256, (8, 8, 3)).astype(np.uint8)
    return cv2.resize(coarse, SMALL.image_size, interpolation=cv2.INTER_CUBIC)


def seen(look: CameraLook, seed: int = 1, frame: int = 0, light: float = 1.0) -> np.ndarray:
    return develop(picture(), SMALL, look, seed, frame, light)


def plainly(image: np.ndarray, look: CameraLook, seed: int, frame: int, light: float) -> np.ndarray:
    """What a look makes of an image, in floats and step after step."""
    if look.lens.blur:
        image = cv2.GaussianBlur(image, (0, 0), look.lens.blur)
    grey = np.tile(WEIGHTS, (3, 1))
    image = cv2.transform(image, grey + look.tone.saturation * (np.eye(3) - grey))
    exposure = developing.exposed(image, look)
    height, width = image.shape[:2]
    v, u = np.mgrid[:height, :width]
    apart = np.hypot(u - 0.5 * width, v - 0.5 * height) / np.hypot(0.5 * width, 0.5 * height)
    lens = 1.0 - look.lens.vignetting * apart**2
    levels = (image * np.array(exposure.balance) / 255.0).clip(0.0)
    level_light = levels**look.tone.contrast * lens[..., None] * exposure.gain
    full = look.sensor.full_well

    def shown(one: np.ndarray | float) -> np.ndarray | float:
        n = look.tone.shoulder
        return one / (1.0 + one**n) ** (1.0 / n) if n else one

    black = look.tone.black
    levels = black + (255.0 - black) * shown(np.minimum(level_light, full)) / shown(full)
    more = max(exposure.gain / look.exposure.gain, 1.0) / light
    sigma = np.sqrt(more * (look.sensor.read_noise**2 + look.sensor.shot_noise**2 * levels))
    bank = developing.noise_of(seed, look.sensor.shared, look.sensor.grain, (width, height))
    top, left = developing.noise_place(seed, frame)
    noise = bank[top : top + height, left : left + width] / developing.NOISE_UNIT
    return (levels + sigma * noise).clip(0.0, 255.0)


@pytest.mark.parametrize(
    ("look", "light"),
    [
        (KITTI, 1.0),
        (KITTI, 0.1),
        (CameraLook(exposure=Exposure(3.0), tone=Tone(1.8)), 1.0),
        (CameraLook(sensor=Sensor(0.7, 3.0, 0.4, shared=0.2, grain=0.8)), 1.0),
        (CameraLook(lens=Lens(1.5, 0.5), tone=Tone(1.0, 0.5, 2.0, 30.0)), 1.0),
    ],
)
def test_the_kernel_equals_plain_numpy_within_a_grey_level(look: CameraLook, light: float) -> None:
    expected = plainly(picture(), look, 5, 9, light)
    assert np.abs(seen(look, 5, 9, light) - expected).max() <= 1.0


@pytest.mark.parametrize("name", CAMERA_LOOKS)
def test_frames_are_the_same_twice_in_any_order_and_leave_their_input_alone(name: str) -> None:
    look, before = find_camera_look(name), picture().copy()
    first = [seen(look, 4, frame) for frame in (0, 1, 2)]
    again = [seen(look, 4, frame) for frame in (2, 1, 0)][::-1]
    assert all(one.tobytes() == two.tobytes() for one, two in zip(first, again, strict=True))
    assert np.array_equal(picture(), before)
    assert all(one.dtype == np.uint8 and one.shape == before.shape for one in first)


def test_neutral_changes_no_byte_and_gives_a_copy() -> None:
    assert seen(PLAIN).tobytes() == picture().tobytes()
    assert seen(PLAIN) is not picture()


def test_noise_depends_on_seed_and_frame() -> None:
    first = seen(KITTI, 1, 0)
    assert (first != seen(KITTI, 2, 0)).any()
    assert (first != seen(KITTI, 1, 1)).any()


def test_noise_grows_with_light_and_with_darkness_around() -> None:
    look = CameraLook(sensor=Sensor(read_noise=1.0, shot_noise=0.3))

    def spread(level: int, light: float = 1.0) -> float:
        flat = np.full((*SMALL.image_size[::-1], 3), level, np.uint8)
        return float(np.std(develop(flat, SMALL, look, 1, 0, light).astype(float) - level))

    assert spread(20) < spread(100) < spread(200)
    assert spread(100) == pytest.approx(np.sqrt(1.0 + 0.09 * 100), rel=0.1)
    assert spread(100, 0.25) == pytest.approx(2.0 * spread(100), rel=0.1)


def test_exposure_brings_the_mean_to_its_aim_within_its_stops() -> None:
    dark = (picture() // 3).astype(np.uint8)
    look = CameraLook(exposure=Exposure(mean=100.0, max_stops=4.0))
    assert (develop(dark, SMALL, look, 1, 0) @ WEIGHTS).mean() == pytest.approx(100.0, abs=6.0)
    less = CameraLook(exposure=Exposure(mean=100.0, max_stops=0.5))
    ratio = develop(dark, SMALL, less, 1, 0).mean() / dark.mean()
    assert ratio == pytest.approx(2.0**0.5, rel=0.03)


def test_stops_come_on_top_and_the_full_well_clips() -> None:
    means = [
        seen(CameraLook(exposure=Exposure(mean=100.0, stops=stops))).mean()
        for stops in (-1.0, 0.0, 1.0)
    ]
    assert means[0] < means[1] < means[2]
    assert (seen(CameraLook(sensor=Sensor(full_well=0.5))) == 255).mean() > 0.2


def test_white_balance_brings_a_cast_to_grey() -> None:
    red = (picture() * (1.0, 0.8, 0.6)).astype(np.uint8)
    means = develop(red, SMALL, CameraLook(exposure=Exposure(white_balance=1.0)), 1, 0)
    assert np.ptp(means.mean(axis=(0, 1))) < 4.0


def test_blur_vignetting_saturation_and_jpeg_do_what_they_say() -> None:
    def edges(image: np.ndarray) -> float:
        return float(np.abs(np.diff(image.astype(float), axis=1)).mean())

    assert edges(seen(CameraLook(lens=Lens(blur=2.0)))) < edges(picture())
    flat = np.full((*SMALL.image_size[::-1], 3), 200, np.uint8)
    dimmed = develop(flat, SMALL, CameraLook(lens=Lens(vignetting=0.5)), 1, 0)
    assert dimmed[0, 0, 0] == pytest.approx(100, abs=3)
    assert dimmed[dimmed.shape[0] // 2, dimmed.shape[1] // 2, 0] == 200
    assert np.ptp(seen(CameraLook(tone=Tone(saturation=0.0))), axis=2).max() == 0
    assert (seen(CameraLook(file=File(30.0))) != picture()).any()


def test_a_black_frame_stays_finite() -> None:
    nothing = np.zeros((*SMALL.image_size[::-1], 3), np.uint8)
    assert develop(nothing, SMALL, KITTI, 1, 0).max() < 20


@pytest.mark.parametrize("name", CAMERA_LOOKS)
def test_labels_ids_and_depth_do_not_know_the_look(name: str) -> None:
    plain, other = (
        Rollout.of(find_scene("street", frames=2, camera_look=look), 3) for look in ("plain", name)
    )
    one, two = (RenderedImages(rollout).render(1) for rollout in (plain, other))
    for part in ("depth", "instances", "semantics"):
        assert np.array_equal(getattr(one, part), getattr(two, part))
    assert (one.image.tobytes() == two.image.tobytes()) == (name == "plain")
    first, second = (record(each.scene, 3) for each in (plain, other))
    assert np.array_equal(first.log.detections.boxes, second.log.detections.boxes)
    assert np.array_equal(first.truth.boxes, second.truth.boxes)


def test_a_look_is_one_for_all_renderers() -> None:
    view, frame = street(), drawn()
    smooth = find_renderer("smooth").render(view)
    one, two = (develop(each.image, view.camera, KITTI, 1, 0) for each in (frame, smooth))
    assert abs(one.mean() - two.mean()) < 2.0

"""Images and boxes in, columns of Detections out."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest

from tests.tracker.samples import IMAGE, LEVEL, locked
from tracker import Detections, Frame, Sequence
from tracker.descriptors import DESCRIPTORS, Classical, Learned
from tracker.errors import BadConfig, BadImage, BadWeights, UnknownName
from tracker.front_end import CUE_SETS, CUES, STAGES, FrontEnd, SequenceWithCues, parse_cues
from tracker.shape import Hourglass, ShapeFit

BOXES = [[100.0, 180.0, 260.0, 280.0], [600.0, 170.0, 680.0, 230.0], [5.0, 5.0, 5.5, 5.5]]
WIDTH, HEIGHT = IMAGE


def picture(seed: int = 0) -> np.ndarray:
    """Coarse coloured noise as large as the camera's image."""
    coarse = np.random.default_rng(seed).integers(0, 256, (HEIGHT // 15, WIDTH // 18, 3))
    return np.kron(coarse, np.ones((15, 18, 1))).astype(np.uint8)


def frame(image: np.ndarray | None, boxes: list = BOXES, index: int = 0) -> Frame:
    return Frame(index, 0.1 * index, Detections.of(boxes), image=image)


@pytest.fixture(scope="module")
def everything() -> FrontEnd:
    """All cues, with the shipped weights."""
    return FrontEnd.of("all")


@pytest.mark.parametrize(
    ("text", "cues"),
    [
        ("none", ()),
        ("all", ("pose", "appearance")),
        ("classical", ("classical",)),
        ("pose, classical", ("pose", "classical")),
        ("appearance,pose,appearance", ("appearance", "pose")),
        ("all,none,pose", ("pose", "appearance")),
    ],
)
def test_cues_are_read_as_the_command_line_writes_them(text: str, cues: tuple) -> None:
    assert parse_cues(text) == cues


def test_wrong_cues_are_named_with_their_cure() -> None:
    with pytest.raises(UnknownName, match="Did you mean 'appearance'"):
        parse_cues("apearance")
    with pytest.raises(BadConfig, match="appearance and classical fill one column"):
        parse_cues("all,classical")


def test_every_descriptor_is_a_cue_and_every_set_of_cues_can_be_measured_at_once() -> None:
    assert set(CUES) == {"pose", *DESCRIPTORS}
    for name, cues in CUE_SETS.items():
        assert parse_cues(name) == cues


def test_a_column_for_every_cue_and_nan_for_a_box_that_shows_nothing(everything) -> None:
    seen = everything(locked(frame(picture())), LEVEL).detections
    assert seen.keypoints.shape == (3, 36, 3)
    assert seen.descriptor.shape == (3, everything.descriptor.length)
    assert seen.shape.shape == (3, 5)
    assert seen.yaw.shape == (3,)
    assert seen.size.shape == (3, 3)
    assert seen.pose_cov.shape == (3, 6, 6)
    assert np.isfinite(seen.keypoints[:2]).all()
    assert np.isfinite(seen.descriptor[:2]).all()
    for column in (seen.keypoints, seen.descriptor, seen.shape, seen.yaw, seen.size):
        assert np.isnan(column[2]).all()


def test_what_was_measured_before_stays_unless_it_is_measured_anew() -> None:
    given = frame(picture())
    boxes = Detections.of(BOXES, yaw=np.ones(3), descriptor=np.zeros((3, 2)))
    seen = FrontEnd.of("classical")(Frame(0, 0.0, boxes, image=given.image), LEVEL).detections
    np.testing.assert_array_equal(seen.yaw, np.ones(3))
    assert seen.descriptor.shape == (3, Classical().length)
    np.testing.assert_array_equal(boxes.descriptor, np.zeros((3, 2)))


def test_a_frame_without_an_image_and_one_without_boxes_have_the_same_columns(everything) -> None:
    seen = everything(frame(picture()), LEVEL).detections
    for other in (frame(None), frame(picture(), []), frame(None, [])):
        found = everything(other, LEVEL).detections
        for name in ("keypoints", "descriptor", "shape", "yaw", "size", "pose_cov"):
            column, like = getattr(found, name), getattr(seen, name)
            assert column.shape == (len(other.detections), *like.shape[1:])
            assert np.isnan(column).all()


@pytest.mark.parametrize("cues", ["pose", "appearance", "classical"])
@pytest.mark.parametrize(
    ("image", "told"),
    [
        (np.zeros((HEIGHT, WIDTH), np.uint8), "COLOR_GRAY2RGB"),
        (np.zeros((HEIGHT, WIDTH, 3), np.uint16), "divide by 256"),
        (np.zeros((HEIGHT, WIDTH, 4), np.uint8), "of uint8"),
        (np.zeros((HEIGHT, WIDTH - 1, 3), np.uint8), f"{WIDTH - 1}x{HEIGHT} pixels, the camera's"),
    ],
    ids=["grey", "16-bit", "with alpha", "of another size"],
)
def test_an_image_that_is_no_8_bit_rgb_of_the_cameras_size_is_refused(cues, image, told) -> None:
    given = frame(None)
    object.__setattr__(given, "image", image)
    with pytest.raises(BadImage, match=told):
        FrontEnd.of(cues)(given, LEVEL)


def test_stages_need_the_network_that_feeds_them_and_weights_their_own_network() -> None:
    with pytest.raises(BadConfig, match="need the keypoint network"):
        FrontEnd(fit=ShapeFit())
    learned = Learned.load()
    with pytest.raises(BadConfig, match="need the keypoint network"):
        FrontEnd(descriptor=learned)
    with pytest.raises(BadConfig, match="keypoint_share"):
        FrontEnd(keypoint_share=0.0)
    other = Learned(learned.weights, learned.mean, learned.grid, "0" * 64, learned.unit)
    with pytest.raises(BadWeights, match="weights are for the keypoint network 000000000000"):
        FrontEnd(Hourglass.load(), descriptor=other)


@dataclass(frozen=True)
class Short:
    """A drive of a few frames."""

    frames: tuple[Frame, ...]
    name: str = "short"
    camera = LEVEL

    def __len__(self) -> int:
        return len(self.frames)

    def __iter__(self) -> Iterator[Frame]:
        return iter(self.frames)


def test_a_drive_is_played_with_its_cues_and_the_time_of_every_stage_is_kept(everything) -> None:
    drive = Short((frame(picture()), frame(picture(1), index=1)))
    seen = SequenceWithCues(drive, everything)
    assert isinstance(seen, Sequence)
    assert (seen.name, seen.camera, len(seen)) == ("short", LEVEL, 2)
    played = list(seen)
    assert [one.index for one in played] == [0, 1]
    assert all(one.detections.descriptor is not None for one in played)
    assert tuple(seen.seconds) == STAGES
    assert min(seen.seconds.values()) > 0.0
    few = SequenceWithCues(drive, FrontEnd.of("classical"))
    assert len(list(few)) == 2
    assert tuple(few.seconds) == ("descriptor",)

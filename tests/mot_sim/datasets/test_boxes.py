"""boxes.csv and camera.toml: anybody's drive as a sequence."""

from pathlib import Path

import numpy as np
import pytest

from mot_sim.datasets.boxes import box_sequence, box_sequences
from tests.mot_sim.datasets.conftest import write
from tests.mot_sim.datasets.test_images import paint
from tracker.errors import BadConfig, BadFile, DatasetNotFound
from tracker.types import Sequence

CAMERA = """\
fx = 90
fy = 90
cx = 50
cy = 20
image_width = 100
image_height = 40
camera_height = 1.5
frame_rate = 20
"""
BOXES = "frame,x_min,y_min,x_max,y_max,score\n0,10,10,20,20,0.5\n2,11,10,21,20,0.75\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with boxes.csv and camera.toml."""
    write(tmp_path / "camera.toml", CAMERA)
    write(tmp_path / "boxes.csv", BOXES)
    return tmp_path


def test_boxes_and_a_camera_are_a_sequence(folder: Path) -> None:
    sequence = box_sequence(folder / "boxes.csv", folder / "camera.toml")
    assert isinstance(sequence, Sequence)
    assert sequence.name == "boxes"
    frames = list(sequence)
    assert [len(frame.detections) for frame in frames] == [1, 0, 1]
    assert [frame.time for frame in frames] == [0.0, 0.05, 0.1]
    assert frames[2].detections.boxes.tolist() == [[11, 10, 21, 20]]
    assert frames[2].detections.scores.tolist() == [0.75]
    assert frames[1].T_now_before is None
    assert frames[1].motion_cov is None


def test_columns_come_in_any_order_and_scores_may_be_missing(folder: Path) -> None:
    write(folder / "boxes.csv", "y_max, y_min, x_max, x_min, frame\r\n20,10,30,5,0\r\n")
    (frame,) = box_sequence(str(folder / "boxes.csv"), str(folder / "camera.toml"), name="mine")
    assert frame.detections.boxes.tolist() == [[5, 10, 30, 20]]
    assert frame.detections.scores.tolist() == [1.0]


def test_a_header_alone_is_an_empty_drive(folder: Path) -> None:
    write(folder / "boxes.csv", "frame,x_min,y_min,x_max,y_max\n")
    assert list(box_sequence(folder / "boxes.csv", folder / "camera.toml")) == []


def test_poses_say_how_the_camera_moved_and_how_long_the_drive_is(folder: Path) -> None:
    rows = [f"1 0 0 0 0 1 0 0 0 0 1 {0.5 * frame}\n" for frame in range(4)]
    poses = write(folder / "poses.txt", "".join(rows))
    sequence = box_sequence(folder / "boxes.csv", folder / "camera.toml", poses=poses)
    frames = list(sequence)
    assert len(sequence) == len(frames) == 4
    assert frames[1].T_now_before is not None
    assert frames[1].motion_cov is not None
    np.testing.assert_allclose(frames[1].T_now_before[:3, 3], [0, 0, -0.5])
    given_cov = np.eye(6)
    sequence = box_sequence(
        folder / "boxes.csv", folder / "camera.toml", poses=poses, motion_cov=given_cov
    )
    np.testing.assert_array_equal(list(sequence)[1].motion_cov, given_cov)


def test_images_ride_in_the_frames(folder: Path) -> None:
    for frame in range(3):
        paint(folder / "images" / f"{frame:06d}.png", (frame, 0, 0), size=(100, 40))
    sequence = box_sequence(folder / "boxes.csv", folder / "camera.toml", folder / "images")
    assert [frame.image[0, 0, 0] for frame in sequence if frame.image is not None] == [0, 1, 2]


def test_images_of_another_size_than_the_camera_file_says_are_refused(folder: Path) -> None:
    paint(folder / "images" / "000000.png", (0, 0, 0), size=(90, 40))
    with pytest.raises(BadConfig, match=r"are 100x40, the images in .* have 90x40"):
        box_sequence(folder / "boxes.csv", folder / "camera.toml", folder / "images")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0,1,2,3,4,.5\n", r":1: no header but '0,1,2,3,4,.5'; the first line names the columns"),
        ("", r":1: no header but 'an empty file'"),
        ("frame,xmi,y_min,x_max,y_max\n", r":1: unknown column 'xmi'.* Did you mean 'x_min'"),
        ("frame,x_min,y_min,x_max\n", r":1: no column y_max: .*; the header is frame,x_min"),
        ("frame,frame,x_min,y_min,x_max,y_max\n", r":1: a column stands twice"),
        (BOXES + "3,1,2,3,nan,1\n", r":4: y_max is not finite: y_max nan"),
        (BOXES + "3,5,2,3,4,1\n", r":4: inverted box: x_min 5, y_min 2, x_max 3, y_max 4"),
        (BOXES + "3,3,2,3,4,1\n", r":4: box without area: x_min 3"),
        (BOXES + "3,200,2,300,4,1\n", r":4: box wholly outside the 100x40 image: x_min 200"),
        (BOXES + "-3,1,2,3,4,1\n", r":4: frame below 0: frame -3"),
        (BOXES + "3,1,2,3,4\n", r":4: 5 values where 6 belong"),
        (BOXES + "3,1,2,three,4,1\n", r":4: x_max is 'three', which is no number"),
    ],
)
def test_bad_boxes_are_refused_with_file_and_line(folder: Path, text: str, message: str) -> None:
    write(folder / "boxes.csv", text)
    with pytest.raises(BadFile, match="boxes.csv" + message):
        box_sequence(folder / "boxes.csv", folder / "camera.toml")


def test_fewer_poses_than_frames_are_refused_by_the_name_of_their_file(folder: Path) -> None:
    poses = write(folder / "poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n")
    table, camera = folder / "boxes.csv", folder / "camera.toml"
    with pytest.raises(BadFile, match=r"^\S*poses.txt: 1 poses, but \S*boxes.csv reaches frame 2,"):
        box_sequence(table, camera, poses=poses)
    paint(folder / "images" / "000004.png", (0, 0, 0), size=(100, 40))
    with pytest.raises(BadFile, match=r"poses.txt: 1 poses, but \S*images reaches .*, 5 in all"):
        box_sequence(table, camera, folder / "images", poses)


@pytest.mark.parametrize("row", ["1 0 0 0 0 1 0 0 0 0 1 {0}\n", "{1} 0 0 {0} 0 0 0 1\n"])
def test_poses_of_unknown_scale_may_leap_and_count_as_unknown_at_first(
    folder: Path, row: str
) -> None:
    rows = [row.format(20 * frame, frame / 20) for frame in range(3)]
    files = folder / "boxes.csv", folder / "camera.toml", None, write(folder / "p", "".join(rows))
    sequence = box_sequence(*files, metric=False)
    for _ in range(2):  # each time anew
        *_, last = sequence
        assert last.T_now_before is not None
        assert last.motion_cov is not None
        assert last.T_now_before[2, 3] == 0.0
        assert last.motion_cov[2, 2] > 0.1
    with pytest.raises(BadConfig, match="--ego-scale auto is for poses in a file"):
        box_sequence(*files[:2], metric=False)


def test_a_leap_of_the_poses_depends_on_the_frame_rate(folder: Path) -> None:
    poses = write(
        folder / "poses.txt", "".join(f"1 0 0 0 0 1 0 0 0 0 1 {20 * z}\n" for z in (0, 1, 2))
    )
    with pytest.raises(BadFile, match=r"poses.txt:2: a leap of 20 m .* 0\.05 s .*--ego-scale auto"):
        box_sequence(folder / "boxes.csv", folder / "camera.toml", poses=poses)
    write(folder / "camera.toml", CAMERA.replace("frame_rate = 20", "frame_rate = 10"))
    assert len(box_sequence(folder / "boxes.csv", folder / "camera.toml", poses=poses)) == 3


def test_missing_files_are_named(folder: Path) -> None:
    with pytest.raises(DatasetNotFound, match=r"nowhere.csv: no boxes"):
        box_sequence(folder / "nowhere.csv", folder / "camera.toml")
    with pytest.raises(DatasetNotFound, match=r"nowhere.txt: no pose file"):
        box_sequence(folder / "boxes.csv", folder / "camera.toml", poses=folder / "nowhere.txt")
    with pytest.raises(DatasetNotFound, match=r"nowhere: no such folder"):
        box_sequence(folder / "boxes.csv", folder / "camera.toml", folder / "nowhere")


def test_motion_can_be_seen_in_the_images(folder: Path) -> None:
    for index in range(3):
        paint(folder / "images" / f"{index:06d}.png", (90, 90, 90), (100, 40))
    table, camera = folder / "boxes.csv", folder / "camera.toml"
    sequence = box_sequence(table, camera, folder / "images", visual=True)
    assert sequence.Ts_world_cam is None
    assert len(list(sequence)) == 3
    assert sequence.motion is not None
    for wrong in ({}, {"images": folder / "images", "poses": folder / "poses.txt"}):
        with pytest.raises(BadConfig, match="needs images, and no poses"):
            box_sequence(table, camera, visual=True, **wrong)


def test_a_folder_holds_a_drive_in_every_file(tmp_path: Path) -> None:
    write(tmp_path / "camera.toml", CAMERA)
    boxes = write(tmp_path / "boxes" / "a.csv", BOXES).parent
    walker = "frame,x_min,y_min,x_max,y_max,class\n0,10,10,20,20,Pedestrian\n"
    write(boxes / "b.csv", walker)
    write(boxes / "notes.md", "no boxes")
    drives = box_sequences(boxes, tmp_path / "camera.toml")
    assert [drive.name for drive in drives] == ["a", "b"]
    assert {drive.kinds for drive in drives} == {("Car", "Pedestrian")}
    assert list(next(iter(drives[1])).found.kinds) == ["Pedestrian"]
    cameras = write(tmp_path / "cameras" / "a.toml", CAMERA).parent
    write(cameras / "b.toml", CAMERA.replace("1.5", "2.5"))
    own = box_sequences(boxes, cameras, kinds=("Car",))
    assert [drive.camera.height for drive in own] == pytest.approx([1.5, 2.5])
    assert len(next(iter(own[1])).found) == 0
    (alone,) = box_sequences(boxes / "a.csv", tmp_path / "camera.toml")
    assert alone.name == "a"
    (cameras / "b.toml").unlink()
    with pytest.raises(DatasetNotFound, match=r"b\.toml: no camera file"):
        box_sequences(boxes, cameras)
    with pytest.raises(DatasetNotFound, match="cameras: no boxes in it"):
        box_sequences(cameras, tmp_path / "camera.toml")


def test_two_files_of_one_name_are_refused(tmp_path: Path) -> None:
    write(tmp_path / "camera.toml", CAMERA)
    boxes = write(tmp_path / "boxes" / "a.csv", BOXES).parent
    write(boxes / "a.txt", BOXES)
    with pytest.raises(BadConfig, match=r"a\.txt: there are two files of boxes for a; keep one"):
        box_sequences(boxes, tmp_path / "camera.toml")

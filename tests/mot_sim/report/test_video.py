"""Videos and pictures on disk."""

import cv2
import numpy as np
import pytest

from mot_sim.report import video, write_image, write_video
from tracker.errors import BadOutput

FRAMES = [np.full((64, 96, 3), 20 * index, np.uint8) for index in range(7)]


def test_all_frames_can_be_read_back(tmp_path) -> None:
    path = write_video(tmp_path / "film.mp4", iter(FRAMES), 10.0)
    assert video.count_frames(path) == 7
    assert path.suffix in (".mp4", ".avi")


def test_without_the_wanted_codec_it_is_an_avi(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(video, "CODECS", ((".mp4", "????"), (".avi", "MJPG")))
    path = write_video(tmp_path / "film.mp4", FRAMES, 10.0)
    assert path.name == "film.avi"
    assert video.count_frames(path) == 7
    assert [file.name for file in tmp_path.iterdir()] == ["film.avi"]


def test_without_any_codec_the_error_names_what_was_tried(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(video, "CODECS", ((".mp4", "????"),))
    with pytest.raises(BadOutput, match=r"tried \?\?\?\? in .mp4"):
        write_video(tmp_path / "film.mp4", FRAMES, 10.0)


def test_a_film_that_cannot_be_read_back_is_an_error(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(video, "count_frames", lambda path: 3)
    with pytest.raises(BadOutput, match="3 of 7"):
        write_video(tmp_path / "film.mp4", FRAMES, 10.0)


def test_a_film_of_no_frames_is_refused(tmp_path) -> None:
    with pytest.raises(BadOutput, match="no frames"):
        write_video(tmp_path / "film.mp4", [], 10.0)


def test_what_is_no_video_has_no_frames(tmp_path) -> None:
    assert video.count_frames(tmp_path / "nothing.mp4") == 0


def test_pictures_come_back_with_red_in_its_place(tmp_path) -> None:
    image = np.zeros((4, 5, 3), np.uint8)
    image[:, :, 0] = 200
    write_image(tmp_path / "red.png", image)
    assert cv2.imread(str(tmp_path / "red.png"))[0, 0].tolist() == [0, 0, 200]


def test_a_picture_without_a_folder_is_an_error(tmp_path) -> None:
    with pytest.raises(BadOutput, match="cannot be written"):
        write_image(tmp_path / "nowhere" / "red.png", FRAMES[0])

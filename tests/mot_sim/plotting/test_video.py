"""Films and pictures on disk."""

import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from mot_sim.plotting import FilmWriter, video, write_image, write_video
from mot_sim.plotting.video import count_frames, find_ffmpeg, require_target
from tracker.errors import BadConfig, BadOutput, OutputExists

COLOURS = [(200, 30, 40), (20, 180, 60), (30, 50, 220), (230, 220, 30), (128, 128, 128)]
FRAMES = [np.full((63, 97, 3), colour, np.uint8) for colour in COLOURS]


def decoded(path: Path) -> list[np.ndarray]:
    """The RGB frames of a film."""
    capture, frames = cv2.VideoCapture(str(path)), []
    while True:
        there, frame = capture.read()
        if not there:
            capture.release()
            return frames
        frames.append(cv2.cvtColor(frame, cv2.COLOR_BGR2RGB))


def described(path: Path) -> str:
    """What ffmpeg says of a file."""
    told = subprocess.run([find_ffmpeg(), "-hide_banner", "-i", str(path)],
                          capture_output=True, text=True, check=False)  # fmt: skip
    return told.stderr


def test_an_mp4_is_h264_as_browsers_play_it(tmp_path) -> None:
    path = write_video(tmp_path / "deep" / "film.mp4", iter(FRAMES), 10.0)
    told = described(path)
    assert "Video: h264" in told
    assert "yuv420p" in told
    assert "98x64" in told  # even sides
    assert "10 fps" in told
    content = path.read_bytes()
    assert content.index(b"moov") < content.index(b"mdat")  # it starts before it is loaded
    assert [each.name for each in path.parent.iterdir()] == ["film.mp4"]


def test_the_colours_of_an_mp4_come_back(tmp_path) -> None:
    frames = decoded(write_video(tmp_path / "film.mp4", FRAMES, 10.0))
    assert len(frames) == len(FRAMES)
    # (The reader of OpenCV 4 takes every film for one with the colours of standard television.)
    apart = 12.0 if int(cv2.__version__.split(".")[0]) >= 5 else 25.0
    for frame, colour in zip(frames, COLOURS, strict=True):
        assert np.abs(frame[20:40, 30:60].mean(axis=(0, 1)) - colour).max() < apart


def test_a_gif_loops_and_keeps_its_colours(tmp_path) -> None:
    path = write_video(tmp_path / "film.gif", FRAMES, 10.0)
    assert b"NETSCAPE2.0\x03\x01\x00\x00" in path.read_bytes()  # loops for ever
    frames = decoded(path)
    assert [frame.shape for frame in frames] == [(63, 97, 3)] * len(FRAMES)
    for frame, colour in zip(frames, COLOURS, strict=True):
        assert np.abs(frame[20:40, 30:60].mean(axis=(0, 1)) - colour).max() < 6.0


def test_a_folder_gets_the_pictures_by_their_numbers(tmp_path) -> None:
    with FilmWriter(tmp_path / "frames", 10.0) as film:
        for number, frame in zip((7, 8, 12), FRAMES, strict=False):
            film.add(frame, number)
    names = sorted(each.name for each in (tmp_path / "frames").iterdir())
    assert names == ["000007.png", "000008.png", "000012.png"]
    assert cv2.imread(str(tmp_path / "frames" / names[0]))[0, 0].tolist() == [40, 30, 200]


@pytest.mark.parametrize("name", ["film.mp4", "film.gif", "frames"])
def test_ctrl_c_keeps_a_shorter_film(tmp_path, name: str) -> None:
    film = FilmWriter(tmp_path / name, 10.0)

    def interrupted() -> None:
        with film:
            for frame in FRAMES[:3]:
                film.add(frame)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert film.frames == 3
    assert [each.name for each in tmp_path.iterdir()] == [name]
    if film.path.is_file():
        assert count_frames(film.path) == 3


def test_ctrl_c_inside_a_frame_leaves_the_whole_ones(tmp_path) -> None:
    film = FilmWriter(tmp_path / "film.mp4", 10.0)

    def interrupted() -> None:
        with film:
            film.add(FRAMES[0])
            film.add(FRAMES[1])
            assert film._encoder is not None
            assert film._encoder._process.stdin is not None
            film._encoder._process.stdin.write(FRAMES[2].tobytes()[:999])
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert (film.frames, count_frames(film.path)) == (2, 2)


@pytest.mark.parametrize("name", ["film.mp4", "film.gif", "frames"])
@pytest.mark.parametrize("count", [0, 2])
def test_an_error_leaves_nothing_and_an_older_film_stands(tmp_path, name: str, count: int) -> None:
    write_video(tmp_path / "film.mp4", FRAMES, 10.0)
    before = (tmp_path / "film.mp4").read_bytes()

    def failing() -> None:
        with FilmWriter(tmp_path / name, 10.0) as film:
            for frame in FRAMES[:count]:
                film.add(frame)
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        failing()
    assert [each.name for each in tmp_path.iterdir()] == ["film.mp4"]
    assert (tmp_path / "film.mp4").read_bytes() == before


def test_frames_of_another_size_and_no_frames_are_refused(tmp_path) -> None:
    with pytest.raises(BadOutput, match="after ones of"):
        write_video(tmp_path / "film.mp4", [FRAMES[0], FRAMES[1][:40]], 10.0)
    with pytest.raises(BadOutput, match="no frames"):
        write_video(tmp_path / "film.mp4", [], 10.0)
    assert list(tmp_path.iterdir()) == []


def test_a_film_that_cannot_be_read_back_is_an_error(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(video, "count_frames", lambda path: 3)
    with pytest.raises(BadOutput, match="3 of 5"):
        write_video(tmp_path / "film.mp4", FRAMES, 10.0)
    assert list(tmp_path.iterdir()) == []


def test_an_ffmpeg_that_fails_is_one_error(tmp_path, monkeypatch) -> None:
    failing = tmp_path / "failing"
    failing.write_text("#!/bin/sh\necho the disk is full >&2\nexit 1\n")
    failing.chmod(0o755)
    monkeypatch.setattr("mot_sim.plotting.video.find_ffmpeg", lambda: str(failing))
    large = [np.zeros((400, 400, 3), np.uint8)] * 9  # more than a pipe holds
    for frames in (FRAMES, large):
        with pytest.raises(BadOutput, match="the disk is full"):
            write_video(tmp_path / "film.mp4", frames, 10.0)


@pytest.mark.parametrize("name", ["film.mp4", "film.gif"])
def test_without_ffmpeg_the_error_says_what_to_install(tmp_path, monkeypatch, name: str) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(BadConfig, match="pip install imageio-ffmpeg, or write a folder of PNG"):
        require_target(tmp_path / name)
    require_target(tmp_path / "frames")


def test_without_a_program_for_this_machine_the_error_says_so(tmp_path, monkeypatch) -> None:
    def missing() -> str:
        raise RuntimeError("No ffmpeg exe could be found")

    monkeypatch.setattr("imageio_ffmpeg.get_ffmpeg_exe", missing)
    with pytest.raises(BadConfig, match="IMAGEIO_FFMPEG_EXE"):
        require_target(tmp_path / "film.mp4")


def test_targets_are_checked_before_any_work(tmp_path) -> None:
    (tmp_path / "file").write_text("")
    write_video(tmp_path / "frames", FRAMES[:1], 10.0)
    write_video(tmp_path / "old.mp4", FRAMES[:1], 10.0)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "000000.png.txt").write_text("")
    (tmp_path / "folder.mp4").mkdir()
    for name, error, told in (
        ("film.avi", BadConfig, "no film ends in '.avi'; give .mp4, .gif, or a folder"),
        ("old.mp4", OutputExists, "exists; give --overwrite"),
        ("frames", OutputExists, "not empty; give --overwrite"),
        ("mine", OutputExists, "holds 000000.png.txt, which is no film's"),
        ("file", OutputExists, "exists; name another folder"),
        ("folder.mp4", BadOutput, "is a folder"),
        ("file/film.mp4", BadOutput, "no folder that can be written to"),
    ):
        with pytest.raises(error, match=told):
            require_target(tmp_path / name)
    require_target(tmp_path / "old.mp4", overwrite=True)
    require_target(tmp_path / "frames", overwrite=True)
    require_target(tmp_path / "new" / "film.mp4")
    with pytest.raises(OutputExists):
        require_target(tmp_path / "mine", overwrite=True)
    assert not (tmp_path / "new").exists()


def test_overwriting_replaces_the_whole_folder(tmp_path) -> None:
    write_video(tmp_path / "frames", FRAMES, 10.0)
    write_video(tmp_path / "frames", FRAMES[:2], 10.0)
    assert len(list((tmp_path / "frames").iterdir())) == 2
    assert [each.name for each in tmp_path.iterdir()] == ["frames"]


def test_what_is_no_video_has_no_frames(tmp_path) -> None:
    assert count_frames(tmp_path / "nothing.mp4") == 0


def test_pictures_come_back_with_red_in_its_place(tmp_path) -> None:
    image = np.zeros((4, 5, 3), np.uint8)
    image[:, :, 0] = 200
    write_image(tmp_path / "red.png", image)
    assert cv2.imread(str(tmp_path / "red.png"))[0, 0].tolist() == [0, 0, 200]


def test_a_picture_without_a_folder_is_an_error(tmp_path) -> None:
    with pytest.raises(BadOutput, match="cannot be written"):
        write_image(tmp_path / "nowhere" / "red.png", FRAMES[0])

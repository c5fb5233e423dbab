"""Clips and pictures of results: what can be shown, and why the rest is left out."""

from dataclasses import replace
from pathlib import Path

from mot_sim.report.page.media import load_media
from mot_sim.report.page.sources import ResultSource
from tests.mot_sim.report.page.made import stress_result


def source(folder: Path, *names: str) -> ResultSource:
    """A result with files."""
    return ResultSource(folder, replace(stress_result(), files=names), "")


def test_files_are_taken_in_turns_until_the_room_is_full(tmp_path: Path) -> None:
    for place in "ab":
        (tmp_path / place).mkdir()
        for number in range(2):
            (tmp_path / place / f"{number}.png").write_bytes(b"x" * 3000)
    sources = [source(tmp_path / place, "0.png", "1.png") for place in "ab"]
    media = load_media(sources, 13_000)  # three of them, at 4 bytes for 3
    shown = {place: [each.uri is not None for each in held] for place, held in media.items()}
    assert shown == {0: [True, True], 1: [True, False]}
    assert media[1][1].reason == "0.0 MB: the page would be too large"


def test_a_clip_that_no_browser_plays_is_left_out(tmp_path: Path) -> None:
    (tmp_path / "old_clip.mp4").write_bytes(b"ftypisom....mp4v....")
    (tmp_path / "new-clip.mp4").write_bytes(b"ftypisom....avc1....")
    (old, new) = load_media([source(tmp_path, "old_clip.mp4", "new-clip.mp4")], 10_000)[0]
    assert old.uri is None
    assert old.reason.startswith("no H.264: browsers do not play it")
    assert new.is_clip
    assert new.title == "new clip"


def test_what_is_missing_or_of_no_known_kind_is_left_out(tmp_path: Path) -> None:
    missing, strange = load_media([source(tmp_path, "a.png", "b.exe")], 10_000)[0]
    assert missing.reason == "cannot be read: No such file or directory"
    assert strange.reason == "no browser shows .exe in a page"


def test_nothing_gives_nothing(tmp_path: Path) -> None:
    assert load_media([], 10) == {}
    assert load_media([source(tmp_path)], 10) == {0: []}

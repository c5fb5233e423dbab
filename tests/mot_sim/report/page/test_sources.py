"""Which folders are results: finished ones, half-finished sweeps, runs; and what is none."""

import json
from dataclasses import replace
from pathlib import Path

import pyarrow as pa
import pytest

from mot_sim.evaluation.run_folder import RunFolder, SequenceStatistics
from mot_sim.experiments.result_file import write_result
from mot_sim.experiments.sweep.running import sweep
from mot_sim.report.page import find_sources
from mot_sim.report.page.sources import ResultSource, load_media
from mot_sim.report.page.verdicts import verdicts_of
from tests.mot_sim.experiments.small import small_design, trial_files
from tests.mot_sim.report.page.made import EVERY, stress_result, sweep_result, write_every
from tracker import Tracks
from tracker.errors import BadConfig, BadFile


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, pa.Table]:
    """A folder of a small sweep, without a result.json."""
    folder = tmp_path_factory.mktemp("sweep")
    return folder, sweep(small_design(frames=3), folder)


@pytest.fixture
def half(tmp_path: Path, swept: tuple[Path, pa.Table]) -> Path:
    """A sweep of 12 trials that was left after 5."""
    folder = tmp_path / "half"
    folder.mkdir()
    (folder / "sweep.json").write_bytes((swept[0] / "sweep.json").read_bytes())
    for path in trial_files(swept[0])[:5]:
        copy = folder / path.relative_to(swept[0])
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_bytes(path.read_bytes())
    return folder


def test_folders_come_in_order_and_each_once(tmp_path: Path) -> None:
    folders = write_every(tmp_path)
    found = find_sources([folders[1], folders[0], folders[1]])
    assert [source.result.kind for source in found] == ["stress", "sweep"]
    assert found[0].result == stress_result()
    assert len(found[0].sha256) == 64


def test_a_folder_of_folders_gives_those_below_it(tmp_path: Path) -> None:
    write_every(tmp_path)
    (tmp_path / "other").mkdir()
    found = find_sources([tmp_path])
    assert [source.result.kind for source in found] == sorted(each.kind for each in EVERY)


def test_a_half_finished_sweep_is_shown_as_far_as_it_is(half: Path) -> None:
    (source,) = find_sources([half])
    made = source.result.made
    assert (made.finished, made.trials) == (False, (5, 12))
    means = source.result.table("means")
    assert means is not None
    assert sum(seeds for seeds in means.column("seeds") if isinstance(seeds, int)) == 5
    assert source.result.title == "crossing: detector.jitter"


def test_means_of_what_is_there_are_those_of_the_whole(swept: tuple[Path, pa.Table]) -> None:
    (source,) = find_sources([swept[0]])
    assert (source.result.made.finished, source.result.made.trials) == (True, (12, 12))
    means = source.result.table("means")
    assert means is not None
    rows = [row for row in swept[1].to_pylist() if row["point"] == 0 and row["tracker"] == "paper"]
    expected = sum(row["HOTA"] for row in rows) / len(rows)
    assert means.column("HOTA")[1] == pytest.approx(expected)


def test_a_half_finished_sweep_keeps_the_command_that_was_begun(half: Path) -> None:
    made = sweep_result().made
    begun = type(made)("mot-sim sweep --begun", made.versions, made.code, False, (0, 12))
    write_result(half, type(sweep_result())("sweep", "begun", begun, ()))
    (source,) = find_sources([half])
    assert source.result.made.command == "mot-sim sweep --begun"
    assert source.result.made.trials == (5, 12)


def test_the_first_tracker_may_be_the_one_that_is_missing(half: Path) -> None:
    for path in trial_files(half):
        if json.loads(path.read_text())["about"]["tracker"] == "default":
            path.unlink()
    (source,) = find_sources([half])
    means, less = source.result.table("means"), source.result.table("differences")
    assert means is not None
    assert set(means.column("tracker")) == {"paper"}
    assert less is not None
    assert set(less.column("HOTA")) == {None}


def test_an_empty_sweep_says_so(half: Path) -> None:
    for path in trial_files(half):
        path.unlink()
    (source,) = find_sources([half])
    assert source.result.made.trials == (0, 12)
    assert source.result.tables == ()


def test_trials_that_are_damaged_do_not_count(half: Path) -> None:
    trial_files(half)[0].write_text("{")
    assert find_sources([half])[0].result.made.trials == (4, 12)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"format": 99}, "a sweep of format 99"),
        ({"design": 3}, "no sweep of ours"),
        ({"design": {"axes": {}}}, "cannot be understood here"),
        ({"versions": None}, "no sweep of ours"),
    ],
)
def test_a_sweep_that_is_none_of_ours_is_named(
    half: Path, change: dict[str, object], told: str
) -> None:
    content = json.loads((half / "sweep.json").read_text())
    (half / "sweep.json").write_text(json.dumps({**content, **change}))
    with pytest.raises(BadFile, match=rf"sweep\.json: .*{told}"):
        find_sources([half])


def test_a_sweep_of_a_tracker_that_is_not_here_says_so(half: Path) -> None:
    content = json.loads((half / "sweep.json").read_text())
    content["design"]["trackers"] = {"mine": {"made_by": "nowhere_to_be_found:Tracker"}}
    (half / "sweep.json").write_text(json.dumps(content))
    with pytest.raises(BadFile, match=r"cannot be understood here: .*nowhere_to_be_found"):
        find_sources([half])


def test_a_run_of_a_tracker_is_a_result_with_its_pictures(tmp_path: Path) -> None:
    folder = tmp_path / "rrc"
    with RunFolder.open(folder, {"tracker": "default", "costs": None}, ["0000", "0001"]) as run:
        run.add("0000", Tracks.empty(), SequenceStatistics(10, 20, 19, 3, 0.5))
    (folder / "clip.mp4").write_bytes(b"")
    (folder / "link.png").symlink_to(tmp_path / "elsewhere.png")
    (source,) = find_sources([folder])
    assert source.result.kind == "run"
    assert not source.result.made.finished
    assert source.result.files == ("clip.mp4",)
    table = source.result.table("sequences")
    assert table is not None
    assert table.rows == (("0000", 10, 20, 19, 3, 0.5),)
    said = [each.text for each in verdicts_of(source.result)]
    assert said[-1] == "1 drive, 10 frames: 20 detections gave 19 rows of 3 ids."
    (folder / "run.json").write_text("[]")
    with pytest.raises(BadFile, match="no run of ours"):
        find_sources([folder])


def test_nothing_of_ours_is_refused_with_the_cure(tmp_path: Path) -> None:
    with pytest.raises(BadConfig, match="nothing to report: name folders"):
        find_sources([])
    with pytest.raises(BadFile, match=r"nothing of ours: no result\.json"):
        find_sources([tmp_path])
    with pytest.raises(BadFile, match=r"no (such folder|folder but a single file)"):
        find_sources([tmp_path / "nowhere"])
    (tmp_path / "file").write_text("")
    with pytest.raises(BadFile, match=r"no (such folder|folder but a single file)"):
        find_sources([tmp_path / "file"])


def test_one_damaged_result_among_others_is_named(tmp_path: Path) -> None:
    folders = write_every(tmp_path)
    (folders[2] / "result.json").write_text("{")
    with pytest.raises(BadFile, match=r"breaking-point.result\.json:1: damaged"):
        find_sources([tmp_path])


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

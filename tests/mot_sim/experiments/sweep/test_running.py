"""Sweeps: one table, the same bits however the work is spread, nothing done twice."""

import json
import shutil
from pathlib import Path
from unittest.mock import patch

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from mot_sim.experiments.sweep import Design, WorkersLost, drives
from mot_sim.experiments.sweep import trial as worker
from mot_sim.experiments.sweep.running import sweep
from tests.mot_sim.experiments.small import BARE, numbers, small_design, trial_files
from tracker.errors import BadConfig, BadFile, OutputExists, TrackingError

ODD = "tests.mot_sim.experiments.odd"


def copy_of(swept: tuple[Path, pa.Table], tmp_path: Path) -> Path:
    return Path(shutil.copytree(swept[0], tmp_path / "copy"))


def times(folder: Path) -> dict[str, int]:
    """When each trial was written, to the nanosecond."""
    return {path.name: path.stat().st_mtime_ns for path in trial_files(folder)}


def test_the_table_has_a_row_a_trial_in_order(swept: tuple[Path, pa.Table]) -> None:
    folder, table = swept
    assert table.num_rows == 3 * 2 * 2
    assert table.column_names[:4] == ["point", "detector.jitter", "seed", "tracker"]
    assert table["detector.jitter"].to_pylist() == [0.0] * 4 + [1.0] * 4 + [3.0] * 4
    assert table["seed"].to_pylist()[:4] == [0, 0, 1, 1]
    assert table["tracker"].to_pylist()[:2] == ["default", "paper"]
    assert {"HOTA", "DetA", "AssA", "MOTA", "IDF1", "CLR_FP", "CLR_FN", "IDSW", "Frag"} <= {
        *table.column_names
    }
    assert table["error"].null_count == table.num_rows
    assert pq.read_table(folder / "table.parquet").equals(table)
    about = json.loads(table.schema.metadata[b"mot-sim sweep"])
    assert about["design"]["scene"] == "crossing"


def test_noise_costs_something(swept: tuple[Path, pa.Table]) -> None:
    hota = swept[1]["HOTA"].to_pylist()
    assert sum(hota[:4]) > sum(hota[8:]) + 0.1


def test_a_finished_sweep_is_read_and_not_repeated(
    swept: tuple[Path, pa.Table], tmp_path: Path
) -> None:
    folder = copy_of(swept, tmp_path)
    before = times(folder)
    assert sweep(small_design(), folder).equals(swept[1])
    assert times(folder) == before


def test_what_is_lost_or_damaged_is_done_again_to_the_same_bits(
    swept: tuple[Path, pa.Table], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = copy_of(swept, tmp_path)
    monkeypatch.setenv("MOT_SIM_CACHE", str(tmp_path / "shared"))
    truth = drives.Recordings.shared().truth_path(small_design().conditions[0], 0)
    truth.parent.mkdir(parents=True)
    truth.write_bytes(b"no truth")
    gone, cut, changed, *kept = trial_files(folder)
    gone.unlink()
    cut.write_text(cut.read_text()[:100])
    changed.write_text(changed.read_text().replace('"IDSW": ', '"IDSW": 9'))
    before = times(folder)
    again = sweep(small_design(), folder)
    assert numbers(again).equals(numbers(swept[1]))
    after = times(folder)
    assert all(after[path.name] == before[path.name] for path in kept)


def test_an_interrupted_sweep_keeps_what_is_finished_and_goes_on(tmp_path: Path) -> None:
    seen: list[int] = []

    def stop(what: str, done: int, total: int) -> None:
        if what == "trials" and done >= 4:
            raise KeyboardInterrupt

    design = small_design()
    with pytest.raises(KeyboardInterrupt):
        sweep(design, tmp_path, progress=stop)
    before = times(tmp_path)
    assert len(before) >= 4
    table = sweep(design, tmp_path, progress=lambda what, done, total: seen.append(done))
    assert table.num_rows == len(design)
    assert seen[0] == len(before)
    assert seen[-1] == len(design)
    assert before.items() <= times(tmp_path).items()


@pytest.mark.slow
def test_two_processes_give_the_same_bits_as_one(
    swept: tuple[Path, pa.Table], tmp_path: Path
) -> None:
    table = sweep(small_design(), tmp_path, jobs=2)
    assert numbers(table).equals(numbers(swept[1]))


def test_one_failing_tracker_does_not_stop_the_others(
    swept: tuple[Path, pa.Table], tmp_path: Path
) -> None:
    folder = copy_of(swept, tmp_path)
    trackers = ("default", "paper", f"odd={ODD}:Raises")
    table = sweep(small_design(trackers=trackers), folder, extend=True)
    rows = table.to_pylist()
    failed = [row for row in rows if row["error"] is not None]
    assert {row["tracker"] for row in failed} == {"odd"}
    assert len(failed) == 6
    assert all(row["HOTA"] is None and row["IDSW"] is None for row in failed)
    assert failed[0]["error"] == "frame 2: ZeroDivisionError: no car at all"
    others = [row for row in rows if row["tracker"] != "odd"]
    assert [row["HOTA"] for row in others] == swept[1]["HOTA"].to_pylist()
    before = times(folder)
    sweep(small_design(trackers=trackers), folder)
    assert times(folder) == before
    sweep(small_design(trackers=trackers), folder, retry=True)
    assert sum(times(folder)[name] != before[name] for name in before) == 6


def test_a_sweep_that_is_extended_does_only_what_is_new(
    swept: tuple[Path, pa.Table], tmp_path: Path
) -> None:
    folder = copy_of(swept, tmp_path)
    before = times(folder)
    table = sweep(small_design(axes={"detector.jitter": (0.0, 2.0, 3.0)}), folder, extend=True)
    after = times(folder)
    assert len(after) == len(before) + 4
    assert before.items() <= after.items()
    assert table["HOTA"].to_pylist()[8:] == swept[1]["HOTA"].to_pylist()[8:]


def test_points_that_come_to_the_same_share_their_trials(
    swept: tuple[Path, pa.Table], tmp_path: Path
) -> None:
    folder = copy_of(swept, tmp_path)
    axes = {"detector.jitter": (1.0,), "detector.misses": (1.0,), "rig.frame_rate": (10.0,)}
    table = sweep(small_design(axes=axes, mode="one_at_a_time"), folder, extend=True)
    assert len(trial_files(folder)) == 12
    assert table["HOTA"].to_pylist() == swept[1]["HOTA"].to_pylist()[4:8] * 3
    assert table["detector.misses"].to_pylist() == [None] * 4 + [1.0] * 4 + [None] * 4


def test_an_axis_of_the_scene_has_a_truth_for_each_level_which_sweeps_share(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MOT_SIM_CACHE", str(tmp_path / "shared"))
    design = small_design(axes={"scene.frames": (2, 3)}, seeds=1, trackers=("default",))
    table = sweep(design, tmp_path / "one")
    assert table["frames"].to_pylist() == [2, 3]
    assert len(list((tmp_path / "shared").rglob("truth/*.npz"))) == 2
    with patch.object(drives, "annotate", side_effect=AssertionError("made again")):
        again = sweep(design, tmp_path / "other")
    assert numbers(again).equals(numbers(table))


def test_where_the_shared_truths_cannot_be_written_they_lie_in_the_sweeps_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setenv("MOT_SIM_CACHE", str(tmp_path / "file"))
    sweep(small_design(axes={"scene.frames": (2,)}, seeds=1, trackers=("default",)), tmp_path / "s")
    assert len(list((tmp_path / "s" / "truth").iterdir())) == 1


def change(folder: Path, **entries: object) -> None:
    file = folder / "sweep.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | entries))


@pytest.mark.parametrize(
    ("entries", "error", "told"),
    [
        ({"format": 99}, BadFile, "format 99"),
        ({"code": "0" * 32}, BadConfig, "other code or libraries"),
        ({"design": []}, BadConfig, "frames was None and is 6"),
        ({"design": 3}, BadFile, "no sweep of ours"),
    ],
)
def test_the_folder_of_another_version_is_refused(
    swept: tuple[Path, pa.Table],
    tmp_path: Path,
    entries: dict[str, object],
    error: type[TrackingError],
    told: str,
) -> None:
    folder = copy_of(swept, tmp_path)
    change(folder, **entries)
    with pytest.raises(error, match=told):
        sweep(small_design(), folder)


def test_the_folder_of_another_sweep_or_of_somebody_else_is_refused(
    swept: tuple[Path, pa.Table], tmp_path: Path
) -> None:
    with pytest.raises(BadConfig, match=r"seeds was 2 and is 3.*--extend"):
        sweep(small_design(seeds=3), swept[0])
    (tmp_path / "thesis.tex").write_text("mine")
    with pytest.raises(OutputExists, match="no sweep"):
        sweep(small_design(), tmp_path, overwrite=True)
    assert (tmp_path / "thesis.tex").read_text() == "mine"


def test_overwriting_removes_the_sweep_and_nothing_else(
    swept: tuple[Path, pa.Table], tmp_path: Path
) -> None:
    folder = copy_of(swept, tmp_path)
    (folder / "notes.txt").write_text("mine")
    design = small_design(axes={"detector.jitter": (5.0,)}, seeds=1, trackers=("default",))
    sweep(design, folder, overwrite=True)
    assert len(trial_files(folder)) == 1
    assert (folder / "notes.txt").is_file()
    with pytest.raises(BadConfig, match="keep one"):
        sweep(design, folder, overwrite=True, extend=True)


def test_a_worker_with_other_code_refuses(tmp_path: Path) -> None:
    with (
        patch.object(worker, "code_digest", lambda: "f" * 32),
        pytest.raises(BadConfig, match="a worker has other code or libraries"),
    ):
        sweep(small_design(), tmp_path)


def test_a_drive_that_cannot_be_made_is_the_error_of_its_trials(tmp_path: Path) -> None:
    def fail(*_: object) -> None:
        raise ArithmeticError("no road")

    with patch.object(worker, "drive_of", fail):
        table = sweep(small_design(seeds=1), tmp_path)
    assert set(table["error"].to_pylist()) == {"no drive: ArithmeticError: no road"}


@pytest.mark.parametrize(
    ("options", "told"), [({"jobs": 0}, "--jobs 0"), ({"jobs": 2, "scheduler": "tcp://x"}, "keep")]
)
def test_a_crew_that_cannot_be_is_refused(options: dict[str, object], told: str) -> None:
    with pytest.raises(BadConfig, match=told):
        sweep(small_design(), **options)


def test_a_sweep_without_a_folder_leaves_nothing_behind() -> None:
    design = Design(
        axes={"detector.jitter": (1.0,)}, trackers=("default",), scene="crossing", seeds=1,
        frames=2, fixed=BARE,
    )  # fmt: skip
    assert sweep(design).num_rows == 1
    with pytest.raises(WorkersLost, match="needs a folder"):
        sweep(design, scheduler="tcp://127.0.0.1:1")

"""Results against truth of one's own: tables with ids, folders of MOTChallenge."""

from pathlib import Path

import pytest

from mot_sim.evaluation.own_scoring import score_against
from tests.mot_sim.datasets.conftest import write
from tracker.errors import BadConfig, BadFile, DatasetNotFound, TrackingError

HEADER = "frame,id,x_min,y_min,x_max,y_max,class\n"
TRUTH = "".join(
    f"{frame},{car},{10 + 60 * car},20,{50 + 60 * car},60,Car\n"
    for frame in range(4)
    for car in (0, 1)
)
# The second car is lost in frame 2, and has another id afterwards.
RESULTS = "".join(
    f"{frame} {car + 5 * (frame == 3 and car)} Car -1 -1 -10 {10 + 60 * car} 20 {50 + 60 * car} 60 "
    "-1 -1 -1 -1000 -1000 -1000 -10 0.9\n"
    for frame in range(4)
    for car in (0, 1)
    if (frame, car) != (2, 1)
)


@pytest.fixture
def results(tmp_path: Path) -> Path:
    return write(tmp_path / "results" / "mine.txt", RESULTS).parent


def counts(results: Path, truth: Path, kind: str = "Car") -> tuple[float, ...]:
    combined = score_against(results, truth, "trackeval", kind).combined
    return tuple(combined[name] for name in ("CLR_TP", "CLR_FN", "CLR_FP", "IDSW"))


def test_a_table_with_ids_is_truth(results: Path, tmp_path: Path) -> None:
    alone = write(tmp_path / "labels.csv", HEADER + TRUTH)
    assert counts(results, alone) == (7, 1, 0, 1)
    folder = write(tmp_path / "truth" / "mine.csv", HEADER + TRUTH).parent
    assert counts(results, folder) == (7, 1, 0, 1)
    write(folder / "other.csv", HEADER + TRUTH)
    assert counts(results, folder) == (7, 1, 0, 1)


def test_results_may_be_rows_of_motchallenge(tmp_path: Path) -> None:
    truth = write(tmp_path / "labels.csv", HEADER + TRUTH)
    rows = "".join(f"{frame + 1},{1},10,20,40,40,1,-1,-1,-1\n" for frame in range(4))
    results = write(tmp_path / "results" / "mine.txt", rows).parent
    assert counts(results, truth) == (4, 4, 0, 0)


def test_results_may_be_tables_of_boxes_beside_what_a_run_leaves(tmp_path: Path) -> None:
    truth = write(tmp_path / "labels.csv", HEADER + TRUTH)
    table = write(tmp_path / "results" / "mine.csv", HEADER + TRUTH)
    assert counts(table, truth) == (8, 0, 0, 0)
    write(table.parent / "run.json", "{}")
    write(table.parent / "mine.estimates.csv", "")
    assert counts(table.parent, truth) == (8, 0, 0, 0)


def test_a_folder_of_motchallenge_goes_by_its_rules(results: Path, tmp_path: Path) -> None:
    """The second car is a distractor: what answers it is no mistake."""
    gt = "".join(
        f"{frame + 1},{car + 1},{10 + 60 * car},20,40,40,{1 - car},{8 if car else 3},1\n"
        for frame in range(4)
        for car in (0, 1)
    )
    home = tmp_path / "mot" / "mine"
    write(home / "gt" / "gt.txt", gt)
    write(home / "seqinfo.ini", "[Sequence]\nname=mine\nseqLength=4\n")
    assert counts(results, tmp_path / "mot") == (4, 0, 0, 0)
    assert score_against(results, tmp_path / "mot", "trackeval", "Car").rules == "motchallenge"
    with pytest.raises(BadConfig, match="--rules devkit2018"):
        score_against(results, tmp_path / "mot", "devkit2018", "Car")
    write(home / "seqinfo.ini", "[Sequence]\nname=mine\n")
    with pytest.raises(BadFile, match=r"seqinfo.ini: no seqLength below \[Sequence\]"):
        counts(results, tmp_path / "mot")
    write(home / "seqinfo.ini", "[Sequence]\nseqLength=3\n")
    with pytest.raises(BadFile, match=r"gt.txt:7: frame beyond the sequence: frame 4"):
        counts(results, tmp_path / "mot")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("frame,x_min,y_min,x_max,y_max\n0,1,2,3,4\n", "no column id"),
        (HEADER + "0,1,9,2,3,4,Car\n", ":2: inverted box: x_min 9"),
        (HEADER + "0,1,1,2,3,4,Car\n0,1,1,2,3,4,Car\n", ":3: an id twice in a frame"),
        (HEADER + "0,1,1,2,3,4,Lorry\n", ":2: no class of KITTI: type Lorry"),
    ],
)
def test_bad_truth_is_named(results: Path, tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(TrackingError, match=f"labels.csv.*{message}"):
        counts(results, write(tmp_path / "labels.csv", text))


def test_truth_that_is_not_there_or_of_other_drives_is_named(results: Path, tmp_path: Path) -> None:
    with pytest.raises(DatasetNotFound, match="no such folder; give boxes with ids"):
        counts(results, tmp_path / "nowhere")
    folder = write(tmp_path / "truth" / "other.csv", HEADER + TRUTH).parent
    with pytest.raises(DatasetNotFound, match=r"has results of mine, but .* the truth of other"):
        counts(results, folder)
    write(folder / "other.json", "[]")
    with pytest.raises(BadConfig, match="two files of truth for other"):
        counts(results, folder)

"""AB3DMOT's scores: by hand on small worlds, and equal to what its own code says."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.datasets import read_labels, read_results
from mot_sim.datasets.kitti.places import TRAINING_FRAMES
from mot_sim.metrics.ab3dmot import Ab3dmot, RecallLevel, ab3dmot_scores, cuts_by_recall
from mot_sim.metrics.cuboid_overlap import Criterion
from mot_sim.metrics.cuboid_preparation import PreparedCuboids, end_to_end, prepare_cuboids
from tests.mot_sim.metrics.cuboid_cases import AHEAD, scene, two_cars
from tracker.errors import BadTracks
from tracker.types import Tracks

CRITERIA = [Criterion("iou", 0.25), Criterion("iou", 0.5), Criterion("iou", 0.7)]
# AB3DMOT's names in the stored cases, and ours.
NAMES = {
    "MOTA": "MOTA", "MOTP": "MOTP", "MODA": "MODA", "MOTAL": "MOTAL", "MODP": "MODP",
    "FAR": "FAR", "recall": "CLR_Re", "precision": "CLR_Pr", "F1": "CLR_F1", "sMOTA": "sMOTA",
    "tp": "CLR_TP", "fp": "CLR_FP", "fn": "CLR_FN", "id_switches": "IDSW", "fragments": "Frag",
    "itp": "neutral_matches", "n_gt": "GT_Dets", "MT": "MTR", "PT": "PTR", "ML": "MLR",
    "score_threshold": "score_threshold", "recall_level": "recall_level",
}  # fmt: skip
FIVE = ("perfect", "one_switch", "one_miss", "false_positive", "rotated")
CASES = (*FIVE, "perfect_exact", "ignored", "overlaps", "ids", "rivals", "long")
# What AB3DMOT's own polygons get wrong where edges coincide.
ARTEFACTS = {"MOTP", "AMOTP", "MODP"}


def scores(truth: Tracks, output: Tracks, frames: int = 5, criterion: str = ".5") -> Ab3dmot:
    parsed = Criterion.parse(criterion)
    return ab3dmot_scores(prepare_cuboids(truth, output, frames), [parsed])[parsed.name]


def test_perfect_results_reach_one_level_less_than_matches():
    perfect = scores(scene(two_cars()), scene(two_cars()))
    assert len(perfect.levels) == 9
    assert perfect.sAMOTA == perfect.AMOTA == pytest.approx(9 / 40)
    assert pytest.approx(9 / 40) == perfect.AMOTP
    assert (perfect.best.counts.MOTA, perfect.best.mean_precision) == (1.0, pytest.approx(1.0))
    assert (perfect.best.counts.MT, perfect.best.counts.ML) == (2, 0)


def test_backwards_cars_score_like_forward_ones():
    backwards = scores(scene(two_cars()), scene(two_cars(yaw=-AHEAD)))
    assert backwards.best.counts.MOTA == 1.0


def test_cars_across_score_by_the_threshold():
    across = scene(two_cars(yaw=0.0))  # 3D IoU 1/3
    assert scores(scene(two_cars()), across, criterion=".3").best.counts.MOTA == 1.0
    nothing = scores(scene(two_cars()), across, criterion=".5")
    assert (nothing.sAMOTA, nothing.levels) == (0.0, ())
    assert nothing.best.counts.MOTA == -1.0  # ten misses, ten false positives of ten labels
    assert scores(scene(two_cars()), across, criterion="2m").best.counts.MOTA == 1.0


def test_a_new_id_is_one_switch():
    rows = [(f, 7 if car and f > 2 else car, *rest) for f, car, *rest in two_cars()]
    switched = scores(scene(two_cars()), scene(rows)).all_tracks.counts
    assert (switched.IDSW, switched.CLR_FN, switched.CLR_FP) == (1, 0, 0)
    assert pytest.approx(0.9) == switched.MOTA


def test_a_missing_row_is_a_miss_and_a_fragment():
    rows = [row for row in two_cars() if row[:2] != (2, 1)]
    missed = scores(scene(two_cars()), scene(rows)).all_tracks.counts
    assert (missed.CLR_FN, missed.CLR_FP, missed.IDSW, missed.Frag) == (1, 0, 0, 1)
    assert pytest.approx(0.9) == missed.MOTA
    assert missed.MT == 1  # the other is tracked in exactly 80 %
    assert missed.PT == 1


def test_a_false_track_of_the_least_score_counts_only_without_a_cut():
    rows = [*two_cars(), (0, 9, 0.0, 60.0)]
    found = scores(scene(two_cars()), scene(rows, scores=[0.9] * 10 + [0.1]))
    assert found.all_tracks.counts.CLR_FP == 1
    assert pytest.approx(0.9) == found.all_tracks.counts.MOTA
    assert found.best.counts.CLR_FP == 0
    assert found.best.counts.MOTA == 1.0


def test_a_track_is_cut_by_its_mean_score():
    rows = sorted([*two_cars(), *((f, 9, 0.0, 60.0) for f in range(5))], key=lambda row: row[:2])
    # The false track's best rows are surer than any other; its mean is less.
    means = {0: [0.5] * 5, 1: [0.5] * 5, 9: [1.0, 1.0, 0.0, 0.0, 0.0]}
    found = scores(scene(two_cars()), scene(rows, scores=[means[row[1]][row[0]] for row in rows]))
    assert found.all_tracks.counts.CLR_FP == 5
    assert found.best.counts.CLR_FP == 0


@pytest.mark.parametrize("how", ["van", "occluded", "truncated"])
def test_a_neutral_label_need_not_be_found_but_may_be(how: str):
    rows = two_cars()
    is_other = [row[1] == 1 for row in rows]
    truth = scene(
        rows,
        kinds=["Van" if other and how == "van" else "Car" for other in is_other],
        occlusion=[3 if other and how == "occluded" else 0 for other in is_other],
        truncation=[1 if other and how == "truncated" else 0 for other in is_other],
    )
    for found in (scene(rows), scene([row for row in rows if row[1] == 0])):
        level = scores(truth, found).all_tracks
        assert level.counts.MOTA == 1.0
        assert level.counts.GT_Dets == 5
        assert level.neutral_matches == len(found) - 5
        assert len(found) == level.counts.CLR_TP


def test_unmatched_results_in_dont_care_or_low_ones_or_vans_are_no_false_positives():
    truth = scene([(0, 0, 0.0, 15.0), (0, -1, 12.0, 15.0)], kinds=["Car", "DontCare"])
    rows = [(0, 1, 0.0, 15.0), (0, 2, 12.0, 30.0), (0, 3, -9.0, 40.0), (0, 4, -14.0, 30.0)]
    found = scene(rows, kinds=["Car", "Car", "Car", "Van"])
    boxes = found.boxes.copy()
    boxes[1] = truth.boxes[1]  # inside DontCare
    boxes[2, 1] = boxes[2, 3] - 25.0  # 25 px high
    assert scores(truth, found.replaced(boxes=boxes), 1).all_tracks.counts.CLR_FP == 0
    boxes[2, 1] -= 0.5
    assert scores(truth, found.replaced(boxes=boxes), 1).all_tracks.counts.CLR_FP == 1


def test_one_pair_more_goes_before_larger_overlaps():
    # Result 1 lies on label 0 and reaches label 1; only so can both be matched.
    truth = scene([(0, 0, 0.0, 20.0), (0, 1, 0.0, 22.0)])
    found = scene([(0, 0, 0.0, 19.0), (0, 1, 0.0, 20.1)])
    level = scores(truth, found, 1, ".3").all_tracks
    assert (level.counts.CLR_TP, level.counts.CLR_FP) == (2, 0)


def test_frames_without_matches_count_one_in_modp():
    level = scores(scene(two_cars(2)), scene(two_cars(1)), frames=2).all_tracks
    # Three frames, as AB3DMOT counts two; all of them 1.
    assert pytest.approx(1.0) == level.MODP
    assert level.FAR == 0.0


def test_nothing_scores_nothing():
    nothing = scene([])
    found = scores(nothing, nothing)
    assert (found.sAMOTA, found.all_tracks.counts.MOTA, found.best.sMOTA) == (0.0, 0.0, 0.0)
    missed = scores(scene(two_cars()), Tracks.empty())
    assert (missed.best.counts.CLR_FN, missed.best.counts.MOTA) == (10, 0.0)


def test_results_without_any_cuboid_are_named():
    found = scene(two_cars()).replaced(cuboids=None)
    with pytest.raises(BadTracks, match=r"output: 10 rows, and none with a cuboid .* in 2D"):
        scores(scene(two_cars()), found)
    nan = scene(two_cars())
    assert nan.cuboids is not None
    unknown = nan.replaced(cuboids=nan.cuboids.replaced(base=nan.cuboids.base * np.nan))
    with pytest.raises(BadTracks, match="output: 10 rows, and none with a cuboid"):
        scores(scene(two_cars()), unknown)


def test_labels_without_cuboids_are_named():
    with pytest.raises(BadTracks, match="truth: 10 rows, and none with a cuboid"):
        scores(scene(two_cars()).replaced(cuboids=None), scene(two_cars()))
    flat = [(*row, 4.0, 0.0, 2.0) if row[:2] == (3, 1) else row for row in two_cars()]
    with pytest.raises(BadTracks, match=r"label of id 1 in frame 3 has no cuboid .size .4.0, 0.0"):
        scores(scene(flat), scene(two_cars()))


def test_a_result_that_lacks_its_cuboid_is_a_false_positive():
    found = scene(two_cars())
    assert found.cuboids is not None
    yaw = found.cuboids.yaw.copy()
    yaw[4] = np.nan
    lacking = found.replaced(cuboids=found.cuboids.replaced(yaw=yaw))
    counts = scores(scene(two_cars()), lacking).all_tracks.counts
    assert (counts.CLR_TP, counts.CLR_FN, counts.CLR_FP) == (9, 1, 1)


def test_a_score_that_is_no_number_is_named():
    with pytest.raises(BadTracks, match="score of row 3 is nan"):
        scores(scene(two_cars()), scene(two_cars(), scores=[0.5] * 3 + [np.nan] + [0.5] * 6))


def random_worlds(seed: int) -> list[PreparedCuboids]:
    """Three small drives with gaps, false tracks and scores."""
    rng = np.random.default_rng(seed)
    worlds = []
    for _ in range(3):
        frames = int(rng.integers(2, 9))
        labels = [
            (f, car, 5.0 * car + rng.normal(0, 0.3), 12.0 + f, AHEAD + rng.normal(0, 0.2))
            for car in range(int(rng.integers(1, 5)))
            for f in range(frames)
            if rng.random() < 0.9
        ]
        found = [
            (f, car + 10 * int(rng.random() < 0.1), x + rng.normal(0, 0.4), z, yaw)
            for f, car, x, z, yaw in labels
            if rng.random() < 0.9
        ]
        found += [(f, 77, -9.0, 20.0, AHEAD) for f in range(frames) if rng.random() < 0.5]
        truth = scene(labels, occlusion=rng.choice([0, 3], len(labels), p=[0.9, 0.1]).tolist())
        output = scene(found, scores=rng.random(len(found)).tolist())
        worlds.append(prepare_cuboids(truth, output, frames))
    return worlds


@given(seed=st.integers(0, 10_000))
def test_counts_of_all_tracks_add_up_over_sequences(seed: int):
    worlds = random_worlds(seed)
    whole = ab3dmot_scores(end_to_end(worlds), CRITERIA[:1])["0.25"].all_tracks.counts
    parts = [ab3dmot_scores(each, CRITERIA[:1])["0.25"].all_tracks.counts for each in worlds]
    for name in ("CLR_TP", "CLR_FN", "CLR_FP", "IDSW", "Frag", "MT", "PT", "ML", "GT_Dets"):
        assert getattr(whole, name) == sum(getattr(part, name) for part in parts)


@given(seed=st.integers(0, 10_000))
def test_averages_are_shares_and_levels_are_forty_at_most(seed: int):
    found = ab3dmot_scores(end_to_end(random_worlds(seed)), CRITERIA)
    for each in found.values():
        assert 0.0 <= each.sAMOTA <= 1.0
        assert each.sAMOTA + 1e-12 >= each.AMOTA
        assert len(each.levels) <= 40
        cuts = [level.score_threshold for level in each.levels]
        assert cuts == sorted(cuts, reverse=True)
    assert found["0.25"].all_tracks.counts.CLR_TP >= found["0.7"].all_tracks.counts.CLR_TP


@given(seed=st.integers(0, 10_000))
def test_scores_on_another_scale_change_nothing(seed: int):
    world = end_to_end(random_worlds(seed))
    scaled = replace(world, track_scores=8.0 * world.track_scores)
    a, b = (ab3dmot_scores(each, CRITERIA[:1])["0.25"] for each in (world, scaled))
    assert (a.sAMOTA, a.AMOTP) == (b.sAMOTA, b.AMOTP)


def test_every_match_is_a_level_when_there_are_few():
    assert cuts_by_recall(np.array([0.1, 0.3, 0.2]), 3) == [(0.2, 0.025), (0.1, 0.05)]
    assert cuts_by_recall(np.zeros(0), 3) == []


def stored_cases(kitti_root: Path, name: str) -> tuple[PreparedCuboids, dict]:
    """A stored case, prepared, and what AB3DMOT's code says of it; else a skip."""
    folder = kitti_root.parent / "golden_scores" / "ab3dmot"
    if not folder.is_dir():
        pytest.skip("no golden result files beside the KITTI root")
    made = folder / "made_up" / name
    told = json.loads(
        (made if made.is_dir() else folder / name).joinpath("expected.json").read_text()
    )
    label = np.eye(4)
    if made.is_dir():
        parts = [
            folder / "made_up" / part for part in (FIVE if name == "five_together" else [name])
        ]
        files = [(part / "label.txt", part / "result.txt", made_frames(part)) for part in parts]
    else:
        labels = kitti_root / "training" / "label_02"
        results = sorted((folder / name / "results").glob("*.txt"))
        files = [(labels / each.name, each, TRAINING_FRAMES[int(each.stem)]) for each in results]
    worlds = [
        prepare_cuboids(read_labels(truth, label), read_results(output, label), frames)
        for truth, output, frames in files
    ]
    return end_to_end(worlds), told.get("scores_restored", told["as_is"])


def made_frames(case: Path) -> int:
    return int(json.loads((case / "expected.json").read_text())["frames"])


def assert_level(ours: RecallLevel, told: dict, without: set[str]) -> None:
    numbers = ours.numbers()
    for name in NAMES.keys() & told.keys() - without:
        assert numbers[NAMES[name]] == pytest.approx(told[name], rel=0.0, abs=1e-9), name


@pytest.mark.kitti
@pytest.mark.parametrize("name", [*CASES, "five_together", "lidar", "mono"])
def test_ab3dmot_says_the_same(kitti_root: Path, name: str):
    world, told = stored_cases(kitti_root, name)
    without = ARTEFACTS if name == "perfect_exact" else set()
    found = ab3dmot_scores(world, CRITERIA)
    assert found.keys() == told.keys()
    for threshold, ours in found.items():
        theirs = told[threshold]
        for average in {"sAMOTA", "AMOTA", "AMOTP"} - without:
            assert getattr(ours, average) == pytest.approx(
                theirs["headline"][average], rel=0.0, abs=1e-9
            ), average
        assert_level(ours.all_tracks, theirs["all_tracks"], without)
        if theirs.get("best") is not None:
            assert_level(ours.best, theirs["best"], without)
        for level, their_level in zip(ours.levels, theirs["per_recall_level"], strict=True):
            assert_level(level, their_level, without)

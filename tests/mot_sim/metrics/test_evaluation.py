"""One name, one number; and sequences put together."""

import json
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from benchmarks.metrics.cases import all_cases, random_case, shuffled, tracks
from benchmarks.metrics.golden import COLUMNS, GOLDEN_FILE
from mot_sim.metrics import RULES, Evaluation, Scores, combine, evaluate, evaluate_sequence
from tests.mot_sim.metrics.kitti_results import golden_results
from tracker.errors import BadConfig, BadTracks, UnknownName
from tracker.types import Tracks


def scores_of(seed: int, rules: str = "trackeval") -> Scores:
    """Scores of one random case."""
    case = random_case(seed)
    return evaluate_sequence(case.truth, case.output, case.frame_count, rules)


def test_a_score_is_found_by_its_name():
    scores = scores_of(5)
    assert scores.hota is not None
    assert scores["HOTA"] == scores.hota.HOTA.mean()
    assert scores["MOTA"] == scores.clear.MOTA


def test_an_unknown_score_names_its_neighbour():
    with pytest.raises(UnknownName, match="Did you mean 'MOTA'"):
        scores_of(5)["MTOA"]


@pytest.mark.parametrize("rules", ["trackeval", "devkit2018"])
def test_scores_are_plain_numbers_for_json(rules: str):
    scores = scores_of(5, rules)
    as_dict = scores.as_dict()
    assert json.loads(json.dumps(as_dict)) == as_dict
    assert all(type(number) in (int, float) for number in scores.numbers().values())


def test_values_over_alpha_come_as_lists():
    by_alpha = scores_of(5).as_dict()["by_alpha"]
    assert {len(values) for values in by_alpha.values()} == {19}


def test_nothing_cannot_be_combined():
    with pytest.raises(BadConfig, match="at least one"):
        combine([])


def test_scores_of_different_rules_cannot_be_combined():
    with pytest.raises(BadConfig, match="same rules"):
        combine([scores_of(5), scores_of(5, "devkit2018")])


GOLDEN = json.loads(GOLDEN_FILE.read_text())
KITTI_TRACKERS = sorted({name.split("/")[1] for name in GOLDEN["rows"] if name.startswith("KITTI")})
BOX = (0.0, 0.0, 40.0, 30.0)
SEEDS = st.integers(0, 100_000)
ONES = (
    "HOTA", "DetA", "AssA", "DetRe", "DetPr", "AssRe", "AssPr", "LocA", "OWTA", "HOTA(0)",
    "LocA(0)", "HOTALocA(0)", "MOTA", "MODA", "MOTP", "sMOTA", "MOTAL", "CLR_Re", "CLR_Pr",
    "CLR_F1", "MTR", "IDF1", "IDR", "IDP",
)  # fmt: skip
ZEROS = "CLR_FP", "CLR_FN", "IDSW", "PT", "ML", "IDFP", "IDFN", "HOTA_FP", "HOTA_FN"
A_FEW = settings(max_examples=25)  # a case is a whole world
BY_EVERY_RULE = pytest.mark.parametrize("rules", sorted(RULES))


def assert_same(ours: Scores, theirs: Scores) -> None:
    """All scores are equal, but for the order of sums."""
    assert ours.numbers() == pytest.approx(theirs.numbers(), rel=0.0, abs=1e-10)


def renamed(table: Tracks, rng: np.random.Generator) -> Tracks:
    """The same rows with other ids; negative ones stay."""
    names = rng.permutation(5000)
    ids = np.where(table.ids < 0, table.ids, names[table.ids])
    return Tracks(
        table.frames, ids, table.boxes, None, table.kinds, table.truncation, table.occlusion
    )


@BY_EVERY_RULE
@A_FEW
@given(seed=SEEDS)
def test_other_ids_change_nothing(rules: str, seed: int):
    case, rng = random_case(seed), np.random.default_rng(seed + 1)
    assert_same(
        evaluate_sequence(case.truth, case.output, case.frame_count, rules),
        evaluate_sequence(
            renamed(case.truth, rng), renamed(case.output, rng), case.frame_count, rules
        ),
    )


@BY_EVERY_RULE
@A_FEW
@given(seed=SEEDS)
def test_the_order_of_rows_is_irrelevant(rules: str, seed: int):
    case, rng = random_case(seed), np.random.default_rng(seed + 1)
    apart = case.output.boxes + rng.normal(0.0, 1e-3, case.output.boxes.shape)  # no exact ties
    output = Tracks(case.output.frames, case.output.ids, apart)
    assert_same(
        evaluate_sequence(case.truth, output, case.frame_count, rules),
        evaluate_sequence(
            shuffled(case.truth, rng), shuffled(output, rng), case.frame_count, rules
        ),
    )


@A_FEW
@given(seed=SEEDS)
def test_perfect_output_scores_one_everywhere(seed: int):
    case = random_case(seed)
    truth = case.truth
    assert truth.kinds is not None
    assert truth.truncation is not None
    assert truth.occlusion is not None
    cars = (truth.kinds == "Car") & (truth.truncation <= 0) & (truth.occlusion <= 2)
    assume(cars.any())
    scores = evaluate_sequence(truth, truth.select(cars), case.frame_count)
    for name in ONES:
        assert scores[name] == pytest.approx(1.0, abs=1e-12), name
    for name in ZEROS:
        assert scores[name] == 0.0, name


@BY_EVERY_RULE
@A_FEW
@given(seed=SEEDS)
def test_one_sequence_combined_is_itself(rules: str, seed: int):
    case = random_case(seed)
    scores = evaluate_sequence(case.truth, case.output, case.frame_count, rules)
    assume(not getattr(scores.clear, "one_sided", False))
    assert_same(combine([scores]), scores)


@A_FEW
@given(seed=SEEDS)
def test_counts_balance(seed: int):
    case = random_case(seed)
    scores = evaluate_sequence(case.truth, case.output, case.frame_count)
    for found, missed, invented in (("CLR_TP", "CLR_FN", "CLR_FP"), ("IDTP", "IDFN", "IDFP")):
        assert scores[found] + scores[missed] == pytest.approx(
            scores["HOTA_TP"] + scores["HOTA_FN"]
        )
        assert scores[found] + scores[invented] == pytest.approx(
            scores["HOTA_TP"] + scores["HOTA_FP"]
        )


@BY_EVERY_RULE
def test_scoring_leaves_its_input_alone(rules: str):
    case = random_case(7)
    before = {field.name: np.copy(getattr(case.output, field.name)) for field in fields(Tracks)[:3]}
    evaluate_sequence(case.truth, case.output, case.frame_count, rules)
    for name, column in before.items():
        np.testing.assert_array_equal(column, getattr(case.output, name))


@BY_EVERY_RULE
def test_an_empty_sequence_can_be_scored(rules: str):
    scores = evaluate_sequence(Tracks.empty(), Tracks.empty(), 0, rules)
    assert scores["CLR_TP"] == 0


@BY_EVERY_RULE
def test_bad_rows_are_turned_away(rules: str):
    good, late = tracks([(0, 1, BOX)]), tracks([(4, 1, BOX)])
    twice = tracks([(0, 1, BOX), (0, 1, BOX)])
    for truth, output, message in (
        (good, late, "output: frame 4 is outside"),
        (late, good, "truth: frame 4 is outside"),
        (good, twice, "output: id 1 stands twice in frame 0"),
        (twice, good, "truth: id 1 stands twice in frame 0"),
    ):
        with pytest.raises(BadTracks, match=message):
            evaluate_sequence(truth, output, 4, rules)


def test_unknown_rules_name_their_neighbour():
    with pytest.raises(UnknownName, match=r"unknown rules 'trackevil'.*Did you mean 'trackeval'"):
        evaluate_sequence(Tracks.empty(), Tracks.empty(), 1, "trackevil")


def test_an_evaluation_is_plain_for_json():
    case = random_case(5)
    evaluation = evaluate({"five": (case.truth, case.output, case.frame_count)})
    as_dict = evaluation.as_dict()
    assert json.loads(json.dumps(as_dict)) == as_dict
    assert as_dict["rules"] == "trackeval"
    assert as_dict["sequences"]["five"]["HOTA"] == as_dict["combined"]["HOTA"]


def assert_golden(evaluation: Evaluation, world: str) -> None:
    """The scores are TrackEval's, wherever the golden file holds them."""
    named = {**evaluation.sequences, "combined": evaluation.combined}
    rows = {name: row for name, row in GOLDEN["rows"].items() if name.startswith(f"{world}/")}
    assert rows
    for name, row in rows.items():
        scores = named[name.rpartition("/")[2]]
        ours = [scores[column] for column in COLUMNS]
        assert ours == pytest.approx(row, rel=0.0, abs=1e-9), name


def test_synthetic_cases_score_as_trackeval_says():
    cases = all_cases()
    assert_golden(
        evaluate({case.name: (case.truth, case.output, case.frame_count) for case in cases}),
        "synthetic/cases",
    )


@pytest.mark.kitti
@pytest.mark.parametrize("tracker", KITTI_TRACKERS)
def test_the_given_sequences_score_as_trackeval_says(kitti_root: Path, tracker: str):
    assert_golden(evaluate(golden_results(kitti_root, tracker)), f"KITTI/{tracker}")


def test_golden_columns_are_those_of_the_file():
    assert GOLDEN["columns"] == COLUMNS


@pytest.mark.kitti
@pytest.mark.parametrize("tracker", ["motsim_rrc", "iou_pointrcnn"])
def test_pedestrians_of_the_given_sequences_score_as_trackeval_says(kitti_root, tracker) -> None:
    rows = golden_results(kitti_root, f"pedestrian/{tracker}")
    folder = kitti_root.parent / "golden_scores" / "pedestrian"
    golden = json.loads((folder / "expected.json").read_text())[tracker]
    evaluation = evaluate(rows, kind="Pedestrian")
    named = {**evaluation.sequences, "combined": evaluation.combined}
    for name in golden:
        ours = named[name].as_dict()
        ours |= ours["by_alpha"]
        known = [score for score in golden[name]["all"] if score in ours]
        assert {"HOTA", "DetA", "AssA", "MOTA", "MOTP", "IDSW", "MT", "IDF1"} < set(known)
        for score in known:
            value = golden[name]["all"][score]
            assert ours[score] == pytest.approx(value, rel=0.0, abs=1e-9), (name, score)


def test_a_class_is_scored_apart_from_the_others() -> None:
    """A person in the way of a pedestrian is neutral, a car among the results is not there."""
    box = np.array([10.0, 10.0, 60.0, 110.0])
    truth = Tracks(
        np.array([0, 0, 0, 1]), np.array([1, 2, 3, 1]), box + [[0], [200], [400], [0]],
        kinds=np.array(["Pedestrian", "Person", "Car", "Pedestrian"]),
    )  # fmt: skip
    output = truth.replaced(kinds=np.array(["pedestrian", "Pedestrian", "Car", "PEDESTRIAN"]))
    walking = evaluate_sequence(truth, output, 2, kind="Pedestrian")
    assert (walking["CLR_TP"], walking["CLR_FP"], walking["CLR_FN"]) == (2, 0, 0)
    driving = evaluate_sequence(truth, output, 2)
    assert (driving["CLR_TP"], driving["CLR_FP"], driving["CLR_FN"]) == (1, 0, 0)
    with pytest.raises(UnknownName, match="class 'Tram'"):
        evaluate_sequence(truth, output, 2, kind="Tram")

"""Weights by cross-validation: the best are found, kept, and judged where they were not chosen."""

from pathlib import Path

import numpy as np
import pytest

from mot_sim.evaluation.runs import track_sequence
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.experiments.tuning.cross_validation import WeightSearch, candidates, neighbours, tune
from mot_sim.experiments.tuning.labelled import LabelledSequence
from mot_sim.experiments.tuning.weighing import WEIGHT_SUM, Method, Scale, Weights, weights_of
from mot_sim.metrics import Devkit2018, Scores, evaluate_sequence
from tests.mot_sim.experiments.made import small_drives
from tracker.errors import BadConfig, MissingCue, UnknownName

NAMES = ("image_overlap", "reprojection", "volume")
PAPER = TrackerSpec("paper", "paper")


@pytest.fixture(scope="module")
def drives(tmp_path_factory: pytest.TempPathFactory) -> tuple[LabelledSequence, ...]:
    return small_drives(tmp_path_factory.mktemp("drives"), 3)


class Planted(Scale):
    """A scale on which everybody knows the best weights: 0.6, 0.3, 0.1."""

    def weigh(self, wanted, tell=None) -> None:
        for weights in wanted:
            off = np.abs(np.array(weights) - (600, 300, 100)).sum()
            clear = Devkit2018(1000, 0, int(off), 0, 0, 0, 0, 0, 0.0, 1000)
            self.known[weights] = {drive.name: Scores(clear) for drive in self.drives}


def test_the_search_finds_the_best_weights(drives) -> None:
    scale = Planted.of(Method(NAMES, PAPER), drives, "devkit2018")
    tuned = tune(scale, WeightSearch("MOTA", samples=10, folds=2), (1.0, 1.0, 1.0))
    assert np.abs(np.array(tuned.weights) - (600, 300, 100)).max() <= 25
    assert tuned.overall > tuned.start
    held = sorted(name for fold in tuned.folds for name in fold.held)
    assert held == sorted(drive.name for drive in drives)
    np.testing.assert_allclose(tuned.balance.sum(axis=0)[:2], 1.0)


@pytest.mark.parametrize("base", ["paper", "default"])
def test_weights_are_worth_what_the_tracker_scores(drives, base: str, tmp_path: Path) -> None:
    method, some = Method(("volume", "image_overlap"), TrackerSpec(base, base)), drives[:1]
    scale = Scale.of(method, some, folder=tmp_path)
    scale.weigh([(500, 500)])
    tracker = method.build(some[0], (500, 500))
    rows, _ = track_sequence(tracker, some[0].sequence)
    wanted = evaluate_sequence(some[0].truth, rows, some[0].frame_count)
    assert scale.known[500, 500][some[0].name].numbers() == wanted.numbers()
    again = Scale.of(method, some, folder=tmp_path)
    again.weigh([(500, 500)])
    assert (scale.fresh, again.fresh) == (1, 0)


def test_an_interrupted_search_goes_on_where_it_was(drives, tmp_path: Path) -> None:
    method, search = Method(("volume", "reprojection"), PAPER), WeightSearch(samples=3, folds=2)

    def interrupt(what: str, done: int, total: int) -> None:
        if done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        tune(Scale.of(method, drives, folder=tmp_path), search, (1.0, 1.0), interrupt)
    assert len(list(tmp_path.rglob("*.json"))) == 3
    resumed = tune(Scale.of(method, drives, folder=tmp_path), search, (1.0, 1.0))
    alone = tune(Scale.of(method, drives), search, (1.0, 1.0))
    assert resumed.fresh == alone.fresh - 3
    assert (resumed.weights, resumed.held_out) == (alone.weights, alone.held_out)


@pytest.mark.slow
def test_processes_find_the_same(drives, tmp_path: Path) -> None:
    method, search = Method(("volume", "reprojection"), PAPER), WeightSearch(samples=2, folds=2)
    alone = tune(Scale.of(method, drives), search, (1.0, 1.0))
    spread = tune(Scale.of(method, drives, folder=tmp_path, jobs=2), search, (1.0, 1.0))
    assert (spread.weights, spread.held_out) == (alone.weights, alone.held_out)


def test_weights_are_thousandths_that_sum_up() -> None:
    assert weights_of([1.0, 1.0, 1.0]) == (334, 333, 333)
    assert weights_of([0.0, 2.0]) == (0, 1000)
    rng = np.random.default_rng(0)
    for row in rng.dirichlet(np.ones(5), 50):
        assert sum(weights_of(row.tolist())) == WEIGHT_SUM


@pytest.mark.parametrize("weights", [[-0.1, 1.0], [0.0, 0.0], [np.nan, 1.0], [np.inf, 1.0], []])
def test_weights_that_cannot_be_are_refused(weights: list[float]) -> None:
    with pytest.raises(BadConfig, match="none below 0 and not all of them 0"):
        weights_of(weights)


def test_draws_are_the_same_for_a_seed_and_others_for_another() -> None:
    start: Weights = (500, 500)
    one, other = candidates(start, WeightSearch(seed=1)), candidates(start, WeightSearch(seed=2))
    assert one == candidates(start, WeightSearch(seed=1))
    assert one != other
    assert one[:3] == [(500, 500), (1000, 0), (0, 1000)]


def test_neighbours_move_weight_between_two_costs() -> None:
    assert neighbours((1000, 0), 200) == [(800, 200)]
    assert set(neighbours((100, 900), 200)) == {(0, 1000), (300, 700)}


def test_a_method_that_cannot_be_is_refused() -> None:
    with pytest.raises(UnknownName, match="Did you mean 'volume'"):
        Method(("volum",))
    with pytest.raises(BadConfig, match="name each once"):
        Method(("volume", "volume"))
    with pytest.raises(BadConfig, match="only ours have weights"):
        Method(("volume",), TrackerSpec("x", "some.module:Thing"))
    with pytest.raises(BadConfig, match="objective IDF1: give HOTA or MOTA"):
        WeightSearch("IDF1")


def test_a_cost_without_its_cue_and_too_many_folds_are_named(drives, tmp_path: Path) -> None:
    bare = small_drives(tmp_path, 2, **{"scene.profile": "rrc"})
    scale = Scale.of(Method(("appearance", "volume"), PAPER), bare)
    with pytest.raises(MissingCue, match="the cost 'appearance' needs descriptors"):
        tune(scale, WeightSearch(folds=2), (1.0, 1.0))
    with pytest.raises(BadConfig, match="5 folds, but only 3 of 3 sequences"):
        tune(Scale.of(Method(("volume",), PAPER), drives), WeightSearch(folds=5), (1.0,))

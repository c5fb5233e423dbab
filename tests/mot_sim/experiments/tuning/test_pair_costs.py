"""Cached pair costs: the tracker itself, at every weight vector, for the price of an assignment."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from mot_sim.evaluation.runs import track_sequence
from mot_sim.experiments.tuning.labelled import LabelledSequence, kitti_drives
from mot_sim.experiments.tuning.pair_costs import Checked, PairCosts
from tests.mot_sim.experiments.made import small_drives
from tracker import Tracker, Tracks
from tracker.costs import COSTS, GatedPairs
from tracker.errors import BadConfig, MissingCue

NAMES = ("appearance", "image_overlap", "reprojection", "shape_pose", "volume")


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> LabelledSequence:
    return small_drives(tmp_path_factory.mktemp("drives"), 1)[0]


def paper(
    drive: LabelledSequence, weights: tuple[float, ...], names: tuple[str, ...] = NAMES
) -> Tracker:
    costs = tuple((weight, COSTS[name]()) for weight, name in zip(weights, names, strict=True))
    return Tracker.paper(drive.sequence.camera, costs)


def in_order(tracks: Tracks) -> Tracks:
    return tracks.select(np.lexsort((tracks.ids, tracks.frames)))


def assert_same(cached: Tracks, tracked: Tracks) -> None:
    one, other = in_order(cached), in_order(tracked)
    np.testing.assert_array_equal(one.frames, other.frames)
    np.testing.assert_array_equal(one.ids, other.ids)
    np.testing.assert_array_equal(one.boxes, other.boxes)


@pytest.mark.parametrize(
    "weights", [(0.2, 0.2, 0.2, 0.2, 0.2), (0.0, 1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.7, 0.0, 0.3)]
)
def test_the_tracks_are_those_of_the_tracker(drive, weights: tuple[float, ...]) -> None:
    cached = PairCosts.of(paper(drive, weights), drive.sequence)
    assert cached is not None
    used = [place for place, weight in enumerate(weights) if weight]
    tracker = paper(drive, tuple(weights[i] for i in used), tuple(NAMES[i] for i in used))
    tracked, _ = track_sequence(tracker, drive.sequence)
    assert len(tracked) > 0
    assert_same(cached.track(weights), tracked)


def test_weights_count_only_by_their_ratio(drive) -> None:
    cached = PairCosts.of(paper(drive, (1.0,) * 5), drive.sequence)
    assert cached is not None
    assert_same(cached.track((1.0, 2.0, 3.0, 4.0, 5.0)), cached.track((0.2, 0.4, 0.6, 0.8, 1.0)))


def test_a_tracker_whose_beliefs_hang_on_matches_is_not_cached(drive) -> None:
    assert PairCosts.of(Tracker.default(drive.sequence.camera), drive.sequence) is None


def test_cues_that_are_missing_in_some_rows_are_not_cached(drive) -> None:
    recorded = drive.sequence.sequence
    holes = recorded.log.detections.descriptor.copy()
    holes[::5] = np.nan
    log = replace(recorded.log, detections=replace(recorded.log.detections, descriptor=holes))
    holed = replace(recorded, log=log)
    assert PairCosts.of(paper(drive, (1.0,), ("appearance",)), holed) is None
    assert PairCosts.of(paper(drive, (1.0,), ("volume",)), holed) is not None


def test_nothing_seen_gives_no_tracks(drive) -> None:
    empty = replace(drive.sequence.sequence, frame_indices=np.zeros(0, np.int64))
    cached = PairCosts.of(paper(drive, (1.0,), ("volume",)), empty)
    assert cached is not None
    assert len(cached.track((1.0,))) == 0


def test_a_cue_that_no_detection_has_is_named(tmp_path: Path) -> None:
    bare = small_drives(tmp_path, 1, **{"scene.profile": "rrc"})[0]
    with pytest.raises(MissingCue, match="the cost 'appearance' needs descriptors"):
        PairCosts.of(paper(bare, (1.0,), ("appearance",)), bare.sequence)


@dataclass(frozen=True)
class Wild:
    value: float

    def __call__(self, pairing: GatedPairs) -> np.ndarray:
        return np.full(len(pairing.pairs[0]), self.value)


@pytest.mark.parametrize("value", [np.inf, -1.0])
def test_a_cost_that_is_no_cost_is_refused(drive, value: float) -> None:
    costs = ((1.0, Checked("wild", Wild(value))),)
    tracker = Tracker.paper(drive.sequence.camera, costs)
    with pytest.raises(BadConfig, match=f"the cost 'wild' gave {value:g}"):
        PairCosts.of(tracker, drive.sequence)


@pytest.mark.kitti
def test_on_kitti_too(kitti_root: Path) -> None:
    (given,) = kitti_drives(kitti_root, "0017")
    names = ("volume", "reprojection")
    cached = PairCosts.of(paper(given, (0.5, 0.5), names), given.sequence)
    assert cached is not None
    tracked, _ = track_sequence(Tracker.paper(given.sequence.camera), given.sequence)
    assert_same(cached.track((0.6, 0.4)), tracked)

"""Many drives tracked at once give what one tracker per drive gives, bit for bit."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from mot_sim.simulation.episode import record
from mot_sim.simulation.registry import find_scene
from tracker import TRACKERS, Camera, Detections, Frame, Tracker
from tracker.association import Greedy, match_in_stages
from tracker.batch import BatchTracker, PreparedFrames, prepare_frames
from tracker.costs import ImageOverlap, Reprojection, Volume
from tracker.errors import BadConfig
from tracker.geometry import homogeneous, rotation_y
from tracker.lifecycle import Lifecycle
from tracker.types import Rows

UNSURE = np.diag(np.square([0.01, 0.01, 0.05, 0.004, 0.008, 0.001]))


def plain(frames: Sequence[Frame]) -> list[Frame]:
    """The frames as recorded."""
    return list(frames)


def jittery(frames: Sequence[Frame]) -> list[Frame]:
    """Motions that are off by some degrees and say so, every seventh one unknown."""
    turned, rng = [], np.random.default_rng(0)
    for frame in frames:
        T = frame.T_now_before
        if T is not None:
            T = (
                None
                if frame.index % 7 == 0
                else homogeneous(rotation_y(rng.normal(0.0, 0.008))) @ T
            )
        turned.append(replace(frame, T_now_before=T, motion_cov=None if T is None else UNSURE))
    return turned


def uneven(frames: Sequence[Frame]) -> list[Frame]:
    """Frames at uneven times, some of them empty."""
    times = np.cumsum(0.1 + 0.05 * (np.arange(len(frames)) % 3))
    none = Detections(np.zeros((0, 4)), np.zeros(0))
    return [
        replace(frame, time=float(time), detections=none if at % 9 == 4 else frame.detections)
        for at, (frame, time) in enumerate(zip(frames, times, strict=True))
    ]


@pytest.fixture(scope="module")
def drives() -> list[list[Frame]]:
    """Three drives of one camera, of different lengths."""
    scenes = [find_scene("street", frames=frames) for frames in (25, 18, 25)]
    return [list(record(scene, seed)) for seed, scene in enumerate(scenes)]


def equal(one: Rows, other: Rows) -> None:
    """Every array of two tables is the same, bit for bit."""
    assert type(one) is type(other)
    for name in type(one).__match_args__:
        mine, theirs = getattr(one, name), getattr(other, name)
        if isinstance(mine, np.ndarray):
            np.testing.assert_array_equal(mine, theirs, err_msg=name, strict=True)
        elif mine is not None or theirs is not None:
            equal(mine, theirs)


# Trackers whose steps differ, by the names that tests give them.
KINDS: dict[str, Callable[[Camera], Tracker]] = {
    **TRACKERS,
    "greedy": lambda camera: replace(Tracker.default(camera), associate=Greedy(0.7)),
    "brief": lambda camera: replace(Tracker.default(camera), lifecycle=Lifecycle(0.8, max_gap=0.0)),
    "all geometry": lambda camera: Tracker.default(
        camera, ((0.5, ImageOverlap()), (0.3, Volume()), (0.2, Reprojection()))
    ),
}


@pytest.mark.parametrize("name", list(KINDS))
@pytest.mark.parametrize("how", [plain, jittery, uneven])
def test_drives_side_by_side_give_what_each_gives_alone(drives, name, how) -> None:
    camera = record(find_scene("street", frames=2), 0).camera
    tracker, given = KINDS[name](camera), [how(frames) for frames in drives]
    alone = [KINDS[name](camera) for _ in given]
    batch, frames, first = BatchTracker(tracker, len(given)), prepared(tracker, []), []
    for each in given:
        first.append(len(frames))
        frames = prepared(tracker, each).after(frames)
    lengths = np.array([len(each) for each in given])
    for step in range(max(map(len, given))):
        at = np.where(step < lengths, np.array(first) + step, 0)
        if step:
            batch.reset(np.flatnonzero(lengths == step))
        compared = batch.compare(frames, at)
        matrices = list(compared.matrices())
        rows = batch.apply_match(compared, compared.match_each(tracker))
        for drive, each in enumerate(given):
            output = rows.output.select(rows.output.frames == drive)
            mine = np.flatnonzero(rows.drives == drive)
            if step >= len(each):
                assert len(output) == len(mine) == 0
                continue
            single, before = alone[drive].cost_matrix(each[step]), alone[drive].state.tracks.ids
            np.testing.assert_array_equal(matrices[drive], single.costs)
            strong = single.detections.scores >= tracker.strong_score
            match = match_in_stages(single.costs, strong, tracker.associate)
            written = alone[drive].apply_match(each[step], single, match)
            state = alone[drive].state
            for column in ("ids", "boxes", "scores"):
                np.testing.assert_array_equal(getattr(output, column), getattr(written, column))
            equal(batch.tracks.select(mine), state.tracks.replaced(cars=None))
            if state.estimates is not None:
                equal(batch.estimates.select(mine), state.estimates)
                for column, number in zip(vars(batch.roads).values(), state.road, strict=True):
                    np.testing.assert_array_equal(column[drive], number)
            sources = rows.sources[mine]
            kept = sources[sources >= 0] - compared.starts[drive]
            np.testing.assert_array_equal(before[kept], state.tracks.ids[sources >= 0])


def prepared(tracker: Tracker, frames: list[Frame]) -> PreparedFrames:
    return prepare_frames(tracker, frames, "a drive")


def test_a_drive_that_begins_anew_forgets_all(drives) -> None:
    tracker = Tracker.default(record(find_scene("street", frames=2), 0).camera)
    frames, batch = prepared(tracker, drives[0]), BatchTracker(tracker, 2)
    seen = []
    for round_ in range(2):
        kept = batch.reset(np.array([0]))
        assert kept.sum() == (0 if round_ == 0 else len(batch.tracks))
        for step in range(6):
            compared = batch.compare(frames, np.array([step, 6 * round_ + step]) + 1)
            rows = batch.apply_match(compared, compared.match_each(tracker))
            seen.append(rows.output.select(rows.output.frames == 0))
    for one, other in zip(seen[:6], seen[6:], strict=True):
        np.testing.assert_array_equal(one.ids, other.ids)
        np.testing.assert_array_equal(one.boxes, other.boxes)


def test_a_frame_that_nothing_looked_at_is_refused(drives) -> None:
    blind = [replace(drives[0][0], detections=None)]
    tracker = Tracker.default(record(find_scene("street", frames=2), 0).camera)
    with pytest.raises(BadConfig, match=r"episode 7: nothing looked at frame 0.*one tracker per"):
        prepare_frames(tracker, blind, "episode 7")

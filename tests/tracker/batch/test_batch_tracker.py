"""Many drives tracked at once give what one tracker per drive gives, row by row."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from mot_sim.simulation.episode import record
from mot_sim.simulation.registry import find_scene
from tracker import TRACKERS, Detections, Frame, Tracker
from tracker.association import Match, match_in_stages
from tracker.batch import BatchCosts, BatchMatch, BatchTracker, PreparedFrames, prepare_frames
from tracker.errors import BadConfig
from tracker.geometry import homogeneous, rotation_y

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


def dense(compared: BatchCosts, drive: int) -> np.ndarray:
    """The cost matrix of one drive."""
    top, left = compared.starts[drive], compared.columns[drive]
    n, m = compared.starts[drive + 1] - top, compared.columns[drive + 1] - left
    matrix = np.full((n, m), np.inf)
    mine = compared.track_drives[compared.pairs[0]] == drive
    matrix[compared.pairs[0][mine] - top, compared.pairs[1][mine] - left] = compared.costs[mine]
    return matrix


def matched(tracker: Tracker, compared: BatchCosts, count: int) -> tuple[BatchMatch, list[Match]]:
    """What the tracker's own association makes of every drive."""
    each, pairs, lost, new = [], [np.zeros((0, 2), int)], [], []
    for drive in range(count):
        top, left = compared.starts[drive], compared.columns[drive]
        scores = compared.detections.scores[left : compared.columns[drive + 1]]
        match = match_in_stages(
            dense(compared, drive), scores >= tracker.strong_score, tracker.associate
        )
        # In the order of rows and columns, as a `BatchMatch` is.
        in_order = match.pairs[np.argsort(match.pairs[:, 0])]
        new_ones = np.sort(match.unmatched_detections)
        match = replace(match, pairs=in_order, unmatched_detections=new_ones)
        each.append(match)
        pairs.append(match.pairs + (top, left))
        lost.append(match.unmatched_tracks + top)
        new.append(match.unmatched_detections + left)
    table = np.concatenate(pairs)
    table = table[np.argsort(table[:, 0])]
    return BatchMatch(table, np.sort(np.concatenate(lost)), np.sort(np.concatenate(new))), each


@pytest.mark.parametrize("name", list(TRACKERS))
@pytest.mark.parametrize("how", [plain, jittery, uneven])
def test_drives_side_by_side_give_what_each_gives_alone(drives, name, how) -> None:
    camera = record(find_scene("street", frames=2), 0).camera
    tracker, given = TRACKERS[name](camera), [how(frames) for frames in drives]
    alone = [TRACKERS[name](camera) for _ in given]
    batch, frames, first = BatchTracker(tracker, len(given)), prepared(tracker, []), []
    for each in given:
        first.append(len(frames))
        frames = prepared(tracker, each).after(frames)
    for step in range(max(map(len, given))):
        lengths = np.array([len(each) for each in given])
        at = np.where(step < lengths, np.array(first) + step, 0)
        if step:
            batch.reset(np.flatnonzero(lengths == step))
        compared = batch.compare(frames, at)
        match, matches = matched(tracker, compared, len(given))
        rows = batch.apply_match(compared, match)
        for drive, each in enumerate(given):
            mine = rows.output.select(rows.output.frames == drive)
            if step >= len(each):
                assert len(mine) == 0
                continue
            single = alone[drive].cost_matrix(each[step])
            np.testing.assert_allclose(dense(compared, drive), single.costs, atol=1e-12)
            written = alone[drive].apply_match(each[step], single, matches[drive])
            np.testing.assert_array_equal(mine.ids, written.ids)
            np.testing.assert_allclose(mine.boxes, written.boxes, atol=1e-9)
            np.testing.assert_allclose(mine.scores, written.scores, atol=1e-9)
            assert (rows.drives == drive).sum() == len(alone[drive].state.tracks)


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
            rows = batch.apply_match(compared, matched(tracker, compared, 2)[0])
            seen.append(rows.output.select(rows.output.frames == 0))
    for one, other in zip(seen[:6], seen[6:], strict=True):
        np.testing.assert_array_equal(one.ids, other.ids)
        np.testing.assert_array_equal(one.boxes, other.boxes)


def test_a_frame_that_nothing_looked_at_is_refused(drives) -> None:
    blind = [replace(drives[0][0], detections=None)]
    tracker = Tracker.default(record(find_scene("street", frames=2), 0).camera)
    with pytest.raises(BadConfig, match=r"episode 7: nothing looked at frame 0.*one tracker per"):
        prepare_frames(tracker, blind, "episode 7")

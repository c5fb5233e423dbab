"""Tables that kernels made: columns are cut out of two arrays where somebody looks."""

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest

from tests.tracker.kernels.plain_renewal import same_values
from tests.tracker.kernels.test_renewing import with_cues
from tests.tracker.kernels.test_tracks import some_tracks
from tracker.beliefs import Beliefs
from tracker.lifecycle import ActiveTracks

COUNTS = pytest.mark.parametrize("count", [0, 1, 5])


def plain(count: int, seed: int = 0) -> ActiveTracks:
    """A table of separate arrays."""
    rng = np.random.default_rng(seed)
    tracks = some_tracks(rng, count, 0.1)
    return tracks.replaced(beliefs=with_cues(tracks.beliefs, rng, 0.5))


def packed(tracks: ActiveTracks) -> ActiveTracks:
    """The same table, of packed columns."""
    cues = {name: getattr(tracks.beliefs, name) for name in ("shape_pose", "embedding")}
    beliefs = Beliefs.of_packed(tracks.packed, **cues)
    return ActiveTracks.of_packed(tracks.packed, beliefs=beliefs, cars=tracks.cars)


@COUNTS
def test_columns_that_were_packed_are_cut_out_as_they_were(count: int) -> None:
    tracks = plain(count)
    again = packed(tracks)
    assert len(again) == len(again.beliefs) == len(again.beliefs.cuboids) == count
    same_values(again, tracks)
    assert again.beliefs.cov is again.beliefs.cov
    assert again.beliefs.cov.flags.c_contiguous


@COUNTS
def test_a_packed_table_does_what_every_table_does(count: int) -> None:
    tracks, rows = plain(count), np.arange(count)[::2]
    some = packed(tracks).select(rows)
    same_values(some, tracks.select(rows))
    same_values(packed(tracks).updated(rows, some), tracks)
    both = ActiveTracks.concatenate((packed(tracks), tracks))
    same_values(both, ActiveTracks.concatenate((tracks, tracks)))
    mine = packed(tracks).copied()
    mine.beliefs.boxes[:] += 1.0
    same_values(packed(tracks), tracks)


def test_rows_are_taken_of_packed_columns_at_once() -> None:
    tracks = plain(5)
    for rows in ([3, 0, 3], [-1, 2], [], [True, False, True, False, False]):
        some = packed(tracks).select(np.array(rows, bool if True in rows else np.int64))
        assert "packed" in vars(some)
        same_values(some, tracks.select(rows))
        some.beliefs.boxes[:] = 0.0  # its own
    for rows in ([5], [-6], [0, 9]):
        with pytest.raises(IndexError):
            packed(tracks).select(np.array(rows))


@COUNTS
def test_what_replaces_a_column_is_packed_anew(count: int) -> None:
    tracks, ones = plain(count), np.ones(count)
    other = packed(tracks).replaced(existence=ones)
    same_values(other, tracks.replaced(existence=ones))
    same_values(packed(other), other)
    same_values(packed(replace(packed(tracks), existence=ones)), other)
    boxes = tracks.beliefs.boxes + 1.0
    same_values(
        packed(tracks).moved_to(boxes),
        tracks.replaced(beliefs=tracks.beliefs.replaced(boxes=boxes)),
    )
    without = packed(tracks.replaced(cars=None)).replaced(cars=None)
    assert "packed" in vars(without)
    same_values(without, tracks)


def test_a_packed_table_cannot_be_written_to() -> None:
    tracks = packed(plain(3))
    for column in (tracks.ids, tracks.scores, tracks.beliefs.boxes, tracks.beliefs.cuboids.base):
        with pytest.raises(ValueError, match="read-only"):
            column[:] = 0


@COUNTS
def test_a_packed_table_is_copied_and_pickled(count: int) -> None:
    tracks = plain(count)
    for again in (pickle.loads(pickle.dumps(packed(tracks))), copy.deepcopy(packed(tracks))):
        same_values(again, tracks)
        assert not hasattr(again, "no_column")
        with pytest.raises(AttributeError, match="'ActiveTracks' object has no attribute 'colour'"):
            again.colour  # noqa: B018

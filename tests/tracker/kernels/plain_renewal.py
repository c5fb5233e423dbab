"""The tracks after a frame, put together by the operations of tables."""

import numpy as np
from jaxtyping import Int
from numpy import ndarray as Array

from tracker.beliefs import Beliefs
from tracker.box_filter import Gains
from tracker.existence import DetectorStatistics, ExistenceUpdate
from tracker.lifecycle import ActiveTracks, Partners
from tracker.renewal import Renewal
from tracker.types import Detections
from tracker.types.rows import Rows


def same_values(found: Rows, expected: Rows) -> None:
    """Assert that two tables hold the same numbers in the same columns."""
    assert type(found) is type(expected)
    for name in expected.__match_args__:
        one, other = getattr(found, name), getattr(expected, name)
        if isinstance(other, Rows):
            same_values(one, other)
        elif other is None:
            assert one is None, name
        else:
            np.testing.assert_array_equal(one, other, err_msg=name)


def plain_renewal(
    how: Renewal,
    tracks: ActiveTracks,
    partners: Partners,
    observed: Beliefs,
    found: Detections,
    learned: tuple[DetectorStatistics, Gains | None],
    dt: float,
    next_id: int,
) -> tuple[ActiveTracks, Int[Array, " n"]]:
    """What `Renewal` makes of a frame: the tracks, and where they come from."""
    rows, columns, missed, born = partners
    existence = ExistenceUpdate.certain(tracks, partners, learned[0])
    if how.existence is not None:
        existence = how.existence(learned[0], tracks, partners, found, dt, how.camera)
    matched, k = tracks.select(rows), len(rows)
    given = matched, observed.select(columns), dt, learned[1]
    beliefs, innovations, _ = how.beliefs_after(*given)
    likely = existence.tracks[rows]
    updated = matched.seen_again(beliefs, found.scores[columns], likely, innovations)
    places = len(tracks) + np.arange(k)
    if len(missed):
        updated = tracks.updated(rows, updated).replaced(existence=existence.tracks)
        places = np.arange(len(tracks))
        places[rows] = len(tracks) + np.arange(k)
        alive = how.lifecycle.are_alive(updated, how.camera)
        updated, places = updated.select(alive), places[alive]
    scores = found.scores[born]
    new = ActiveTracks.born(observed.select(born), scores, existence.born, next_id)
    both = ActiveTracks.concatenate((updated, new))
    return both, np.concatenate((places, len(tracks) + k + born))

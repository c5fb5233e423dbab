"""Matching in two stages, sure detections first (as ByteTrack, Zhang et al., ECCV 2022)."""

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray as Array

from tracker.association.match import Associate, Match


def match_in_stages(
    costs: Float[Array, "n m"], strong: Bool[Array, " m"], associate: Associate
) -> Match:
    """The strong columns first; the weak ones take what is left of the rows."""
    if np.count_nonzero(strong) == len(strong):
        return associate(costs)
    first_columns, second_columns = strong.nonzero()[0], (~strong).nonzero()[0]
    first = associate(costs.take(first_columns, 1))
    second = associate(costs.take(first.unmatched_tracks, 0).take(second_columns, 1))
    rows = np.concatenate((first.pairs[:, 0], first.unmatched_tracks[second.pairs[:, 0]]))
    columns = np.concatenate((first_columns[first.pairs[:, 1]], second_columns[second.pairs[:, 1]]))
    return Match.of(np.array((rows, columns)).T, *costs.shape)

"""Identities over time: ground truth and tracker output are the same type."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int, Shaped
from numpy import ndarray as Array

from tracker.errors import BadTracks
from tracker.types.cuboids import Cuboids
from tracker.types.estimates import CarEstimates
from tracker.types.rows import Rows


@dataclass(frozen=True, eq=False)
class Tracks(Rows):
    """Rows (frame, id, box, ...), in the order of frames; absent columns are None."""

    frames: Int[Array, " n"]
    """Frame of each row, counted from 0."""
    ids: Int[Array, " n"]
    """Identity of the object, >= 0, at most once per frame; -1 in DontCare rows."""
    boxes: Float[Array, "n 4"]
    """x_min, y_min, x_max, y_max, px."""
    scores: Float[Array, " n"] | None = None
    """The tracker's confidence in each row, larger is surer."""
    kinds: Shaped[Array, " n"] | None = None
    """Class as KITTI spells it: 'Car', 'Van', 'DontCare', ..."""
    truncation: Int[Array, " n"] | None = None
    """KITTI's integer level; -1 where the data set does not say."""
    occlusion: Int[Array, " n"] | None = None
    """KITTI's integer level; -1 where the data set does not say."""
    cuboids: Cuboids | None = None
    """Where the objects are, in the road frame of the row's frame."""
    estimates: CarEstimates | None = None
    """The states that the cuboids are part of, with their covariance."""

    @classmethod
    def empty(cls) -> "Tracks":
        """No row at all."""
        return cls(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros((0, 4)), np.zeros(0))

    def require_unique_ids(self, where: str = "tracks") -> None:
        """Raise BadTracks when a frame holds an id twice (negative ids are exempt)."""
        named = np.flatnonzero(self.ids >= 0)
        order = named[np.lexsort((self.ids[named], self.frames[named]))]
        frames, ids = self.frames[order], self.ids[order]
        twice = np.flatnonzero((frames[1:] == frames[:-1]) & (ids[1:] == ids[:-1]))
        if len(twice):
            first = twice[0]
            raise BadTracks(
                f"{where}: id {ids[first]} stands twice in frame {frames[first]}; "
                "an id names one object a frame"
            )

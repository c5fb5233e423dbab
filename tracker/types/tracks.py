"""Identities over time: ground truth and tracker output are the same type."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int, Shaped
from numpy import ndarray as Array

from tracker.errors import BadTracks
from tracker.types.cuboids import Cuboids
from tracker.types.rows import Rows


@dataclass(frozen=True, eq=False)
class Tracks(Rows):
    """Rows (frame, id, box, ...), in the order of frames; absent columns are None.

    boxes: x_min, y_min, x_max, y_max in pixels. scores: of the tracker's output.
    kinds: the class as KITTI spells it ('Car', 'Van', 'DontCare', ...); DontCare has id -1.
    truncation, occlusion: KITTI's integer levels; -1 where the data set does not say.
    cuboids: in the road frame.
    """

    frames: Int[Array, " n"]
    ids: Int[Array, " n"]
    boxes: Float[Array, "n 4"]
    scores: Float[Array, " n"] | None = None
    kinds: Shaped[Array, " n"] | None = None
    truncation: Int[Array, " n"] | None = None
    occlusion: Int[Array, " n"] | None = None
    cuboids: Cuboids | None = None

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

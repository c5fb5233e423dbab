"""Births, coasting through gaps, deaths and ids."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from tracker.beliefs import NEAR, Beliefs
from tracker.types import Camera
from tracker.types.rows import Rows

# Sums of the steps between frames are off by less than this, seconds.
ROUNDING = 1e-6


@dataclass(frozen=True, eq=False)
class Population(Rows):
    """The living tracks: what is believed of each, its id, and how long it was not seen.

    unseen: seconds since the last sighting. sightings: how many there were.
    """

    ids: Int[Array, " n"]
    beliefs: Beliefs
    unseen: Float[Array, " n"]
    sightings: Int[Array, " n"]

    @classmethod
    def empty(cls) -> "Population":
        """Nobody."""
        return cls(np.zeros(0, np.int64), Beliefs.empty(), np.zeros(0), np.zeros(0, np.int64))


NOBODY = Population.empty()


@dataclass(frozen=True)
class Lifecycle:
    """When tracks begin and end.

    birth_score: a detection without a track begins one from this score on, at once.
    max_gap: seconds that a track is remembered without being seen; 0: it dies at the first miss
    (the paper). A track whose expected place has left the view ends as well.
    """

    birth_score: float = 0.0
    max_gap: float = 0.0

    def seen(
        self,
        expected: Population,
        rows: Int[Array, " k"],
        updated: Beliefs,
        observed: Beliefs,
        born: Int[Array, " b"],
        next_id: int,
    ) -> Population:
        """Those seen in this frame: the matched rows with their updated beliefs, then the born."""
        count = len(rows) + len(born)
        ids = np.empty(count, np.int64)
        sightings = np.ones(count, np.int64)
        ids[: len(rows)] = expected.ids[rows]
        sightings[: len(rows)] += expected.sightings[rows]
        if len(born):
            ids[len(rows) :] = next_id + np.arange(len(born))
            updated = Beliefs.concatenate((updated, observed.select(born)))
        return Population(ids, updated, np.zeros(count), sightings)

    def unseen(self, expected: Population, lost: Int[Array, " l"], camera: Camera) -> Population:
        """Those of the lost rows that live on."""
        if len(lost) == 0:
            return NOBODY
        remembered = lost[expected.unseen[lost] <= self.max_gap + ROUNDING]
        coasting = expected.select(remembered)
        inside = in_view(coasting.beliefs, camera)
        return coasting if np.count_nonzero(inside) == len(inside) else coasting.select(inside)


def in_view(beliefs: Beliefs, camera: Camera) -> Bool[Array, " n"]:
    """Whose expected box still lies in the image, and whose expected place before the camera."""
    width, height = camera.image_size
    boxes = beliefs.boxes
    depth = beliefs.cuboids.base @ camera.T_cam_road[2, :3] + camera.T_cam_road[2, 3]
    inside = (boxes[:, 2] > 0.0) & (boxes[:, 0] < width - 1.0)
    return inside & (boxes[:, 3] > 0.0) & (boxes[:, 1] < height - 1.0) & (depth > NEAR)

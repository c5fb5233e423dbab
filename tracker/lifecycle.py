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
# A track unseen for more than this many steps between frames has skipped a frame.
SKIPPED = 1.01


@dataclass(frozen=True, eq=False)
class ActiveTracks(Rows):
    """The living tracks: what is believed of each, its id, and how long it was not seen.

    time_since_update: seconds since the last sighting. hits: how many there were. existence: the
    probability that there is an object. innovations: by how much the last box was off the expected
    one (centre and size, in box heights, a half at most); NaN: not known. scores: of the
    detection in this frame; NaN: not seen in it.
    """

    ids: Int[Array, " n"]
    beliefs: Beliefs
    time_since_update: Float[Array, " n"]
    hits: Int[Array, " n"]
    existence: Float[Array, " n"]
    innovations: Float[Array, "n 4"]
    scores: Float[Array, " n"]

    @classmethod
    def empty(cls) -> "ActiveTracks":
        """Nobody."""
        none, nothing = np.zeros(0, np.int64), np.zeros(0)
        return cls(none, Beliefs.empty(), nothing, none, nothing, np.zeros((0, 4)), nothing)

    @classmethod
    def born(
        cls,
        observed: Beliefs,
        scores: Float[Array, " n"],
        existence: Float[Array, " n"],
        next_id: int,
    ) -> "ActiveTracks":
        """New tracks, with ids from `next_id` on."""
        n = len(scores)
        ids, once = next_id + np.arange(n), np.ones(n, np.int64)
        return cls(ids, observed, np.zeros(n), once, existence, np.full((n, 4), np.nan), scores)

    def seen_again(
        self,
        updated: Beliefs,
        scores: Float[Array, " n"],
        existence: Float[Array, " n"],
        surprises: Float[Array, "n 4"],
    ) -> "ActiveTracks":
        """These tracks after one more sighting each."""
        unseen, sightings = np.zeros(len(scores)), self.hits + 1
        return ActiveTracks(self.ids, updated, unseen, sightings, existence, surprises, scores)


NO_TRACKS = ActiveTracks.empty()


@dataclass(frozen=True)
class Lifecycle:
    """When tracks begin and end.

    birth_score: a detection without a track begins one from this score on, at once.
    max_gap: seconds that a track is remembered without being seen; 0: it dies at the first miss
    (the paper). A track whose expected place has left the view ends as well.
    """

    birth_score: float = 0.0
    max_gap: float = 0.0

    def living(self, population: ActiveTracks, camera: Camera) -> ActiveTracks:
        """Those seen in this frame, and those who are remembered."""
        alive = population.time_since_update <= self.max_gap + ROUNDING
        alive &= in_view(population.beliefs, camera)
        alive |= ~np.isnan(population.scores)
        return population if np.count_nonzero(alive) == len(alive) else population.select(alive)


def in_view(beliefs: Beliefs, camera: Camera) -> Bool[Array, " n"]:
    """Whose expected box still lies in the image, and whose expected place before the camera."""
    width, height = camera.image_size
    boxes = beliefs.boxes
    depth = beliefs.cuboids.base.dot(camera.T_cam_road[2, :3]) + camera.T_cam_road[2, 3]
    inside = (boxes[:, 2] > 0.0) & (boxes[:, 0] < width - 1.0)
    return inside & (boxes[:, 3] > 0.0) & (boxes[:, 1] < height - 1.0) & (depth > NEAR)

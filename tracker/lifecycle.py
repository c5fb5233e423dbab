"""Births, coasting through gaps, deaths and ids."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from tracker.association import Match
from tracker.beliefs import MIN_DEPTH, Beliefs
from tracker.car_filter import CarStates
from tracker.kernels import Kernel
from tracker.types import Camera
from tracker.types.packed import ColumnBlock, Packed, PackedRows, read_only

# Sums of the steps between frames are off by less than this, seconds.
MAX_TIME_ROUNDING = 1e-6
# A track without a detection for more than this many steps between frames has skipped a frame.
MAX_CONSECUTIVE_STEPS = 1.01
KEEP_LIVING = Kernel("tracker.kernels.existing", "keep_living")
SEE_BELIEFS = Kernel("tracker.kernels.existing", "see_beliefs")


@dataclass(frozen=True, eq=False)
class ActiveTracks(PackedRows):
    """The tracks that have not ended, one per row."""

    ids: Int[Array, " n"]
    """Identities, >= 0; no two alike."""
    beliefs: Beliefs
    """Where the objects are, in the road frame of the moment."""
    time_since_update: Float[Array, " n"]
    """Seconds since the last detection, >= 0."""
    hits: Int[Array, " n"]
    """Number of detections so far, >= 1."""
    existence: Float[Array, " n"]
    """Probability that there is an object, 0 to 1."""
    innovations: Float[Array, "n 4"]
    """The last box less the predicted one: centre and size, in box heights, cut at +-0.5; NaN: not
    known."""
    scores: Float[Array, " n"]
    """Score of the detection in this frame; NaN: not detected in it."""
    cars: CarStates | None = None
    """The state of the car behind each track; None without a `CarFilter`."""

    BLOCKS: ClassVar[Mapping[str, ColumnBlock]] = {
        "ids": ColumnBlock(0, 1, is_whole=True),
        "beliefs": ColumnBlock(0, 29, table=Beliefs),
        "time_since_update": ColumnBlock(29, 1),
        "hits": ColumnBlock(1, 1, is_whole=True),
        "existence": ColumnBlock(30, 1),
        "innovations": ColumnBlock(31, 4, (4,)),
        "scores": ColumnBlock(35, 1),
    }

    @classmethod
    def empty(cls) -> "ActiveTracks":
        """No track."""
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
        innovations: Float[Array, "n 4"],
    ) -> "ActiveTracks":
        """These tracks after one more hit each."""
        return self.replaced(
            beliefs=updated,
            time_since_update=np.zeros(len(scores)),
            hits=self.hits + 1,
            existence=existence,
            innovations=innovations,
            scores=scores,
        )

    def expected_at(self, boxes: Float[Array, "n 4"]) -> "ActiveTracks":
        """These tracks with the boxes that a `CarFilter` expects, px.

        Those of a single detection stay: it tells not where the car is going.
        """
        boxes = np.where((self.hits > 1)[:, None], boxes, self.beliefs.boxes)
        return self.replaced(beliefs=self.beliefs.replaced(boxes=boxes))

    def moved_to(self, boxes: Float[Array, "n 4"]) -> "ActiveTracks":
        """These tracks with other boxes, px."""
        n, floats, ints = self.packed
        floats = floats.copy()
        floats[25 * n : 29 * n] = boxes.reshape(-1)
        packed, before = Packed(n, read_only(floats), ints), self.beliefs
        cues = {"shape_pose": before.shape_pose, "embedding": before.embedding}
        beliefs = Beliefs.of_packed(packed, **cues)
        return ActiveTracks.of_packed(packed, beliefs=beliefs, cars=self.cars)


NO_TRACKS = ActiveTracks.empty()


class Partners(NamedTuple):
    """Which tracks and detections of a frame belong together, and what becomes of the others."""

    rows: Int[Array, " k"]
    """The tracks that were detected; no two alike."""
    columns: Int[Array, " k"]
    """By which detection each of them was."""
    missed: Int[Array, " l"]
    """The other tracks."""
    born: Int[Array, " b"]
    """Detections that begin tracks."""


@dataclass(frozen=True)
class Lifecycle:
    """When tracks begin and end; one whose predicted place has left the view ends as well."""

    birth_score: float = 0.0
    """A detection without a track begins one from this score on, at once; more: fewer false tracks,
    later births."""
    max_gap: float = 0.0
    """Seconds that a track lives on without a detection; 0: it ends at the first miss (the paper);
    more: longer gaps are bridged."""

    @property
    def longest_gap(self) -> float:
        """`max_gap` with what sums of steps are off by, s."""
        return self.max_gap + MAX_TIME_ROUNDING

    def partners(self, match: Match, scores: Float[Array, " m"]) -> Partners:
        """Who is who by this match. scores: of all detections."""
        rows, columns = match.pairs.T
        born = match.unmatched_detections
        if len(born):
            born = born[scores[born] >= self.birth_score]
        return Partners(rows, columns, match.unmatched_tracks, born)

    def living(self, tracks: ActiveTracks, camera: Camera) -> ActiveTracks:
        """Those detected in this frame, and those that live on without."""
        alive = self.are_alive(tracks, camera)
        return tracks if np.count_nonzero(alive) == len(alive) else tracks.select(alive)

    def are_alive(self, tracks: ActiveTracks, camera: Camera) -> Bool[Array, " n"]:
        """Which tracks those are."""
        alive, longest = np.empty(len(tracks), bool), self.longest_gap
        place = tracks.beliefs.cuboids.base, tracks.beliefs.boxes, *seen_from(camera)
        KEEP_LIVING(*place, tracks.time_since_update, tracks.scores, longest, alive)
        return alive


def in_view(beliefs: Beliefs, camera: Camera) -> Bool[Array, " n"]:
    """Whose predicted box still lies in the image, and whose place before the camera."""
    seen = np.empty(len(beliefs), bool)
    SEE_BELIEFS(beliefs.cuboids.base, beliefs.boxes, *seen_from(camera), seen)
    return seen


def seen_from(camera: Camera) -> tuple[Float[Array, "4"], Float[Array, "4"], float]:
    """What tells depths of the road frame; the image's corners; the least depth."""
    return camera.T_cam_road[2], camera.far_corner, MIN_DEPTH

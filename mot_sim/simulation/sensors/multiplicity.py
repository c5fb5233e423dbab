"""One car in two boxes (duplicates, splits), and two cars in one (merges)."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array
from scipy.special import expit, ndtr

from mot_sim.simulation import random_numbers
from mot_sim.simulation.sensors.boxes import move_boxes, overlapping_pairs, pair_ids
from mot_sim.simulation.sensors.checks import (
    require_finite,
    require_rates,
    require_sigmas,
    require_table,
)
from mot_sim.simulation.sensors.correlated_noise import Autocorrelation, bursts, correlated_normals
from mot_sim.simulation.sensors.jitter import UNSURE_SCORE
from mot_sim.simulation.sensors.misses import VISIBLE_KNOTS
from mot_sim.simulation.sensors.sightings import Sightings
from tracker.errors import BadConfig
from tracker.geometry import box_iou

MIN_DUPLICATE_IOU = 0.1  # IoU with an object from which a false box is about it
MAX_JUMP_IOU = 0.85  # of a box with itself a frame before, its car aside: from here it jumps
EXAMPLE_COLUMNS = ("dx", "dy", "dw", "dh", "log_odds")


@dataclass(frozen=True)
class Duplicates:
    """Second boxes about one car, as examples of real ones lie beside the first box."""

    seen: tuple[float, ...] = (0.0,) * len(VISIBLE_KNOTS)
    """Rate of a second box for cars that are seen, 0 to 1 at each visible fraction of
    VISIBLE_KNOTS."""
    missed: tuple[float, ...] = (0.0,) * len(VISIBLE_KNOTS)
    """Rate of such a box for cars that are missed, 0 to 1 at each visible fraction of
    VISIBLE_KNOTS."""
    dx: tuple[float, ...] = (0.0,)
    """Of examples of second boxes: the centre's offset, in parts of the first box's width."""
    dy: tuple[float, ...] = (0.0,)
    """Of each example: the centre's offset, in parts of the first box's height."""
    dw: tuple[float, ...] = (0.0,)
    """Of each example: log(its width / the first one's)."""
    dh: tuple[float, ...] = (0.0,)
    """Of each example: log(its height / the first one's)."""
    log_odds: tuple[float, ...] = (0.0,)
    """Of each example: the score's log-odds; higher: second boxes look surer."""
    at_jumps: float = 0.0
    """Rate, 0 to 1, at which a box that jumps is also reported where it was before (only where
    jitter holds errors); more: two boxes that take each other's place."""
    at_unsure_jumps: float = 0.0
    """The same of boxes with a score below UNSURE_SCORE."""
    autocorrelation: Autocorrelation = field(default_factory=Autocorrelation)
    """How second boxes are correlated over time; slower: they stay for more frames."""

    def __post_init__(self) -> None:
        for rates in (self.seen, self.missed):
            require_table("duplicates", VISIBLE_KNOTS, rates)
            require_rates("duplicates", *rates)
        require_rates("duplicates at_jumps, ...", self.at_jumps, self.at_unsure_jumps)
        for name in EXAMPLE_COLUMNS:
            require_finite(f"duplicates {name}", *getattr(self, name))
        counts = {name: len(getattr(self, name)) for name in EXAMPLE_COLUMNS}
        if len(set(counts.values())) > 1 or not counts["dx"]:
            raise BadConfig(f"duplicates: {counts} examples; give as many of each, one or more")

    @property
    def has_jumps(self) -> bool:
        """Whether any box that jumps is left behind."""
        return max(self.at_jumps, self.at_unsure_jumps) > 0.0

    @cached_property
    def examples(self) -> Float[Array, "e 5"]:
        """dx, dy, dw, dh and log-odds of the examples, those of like places side by side."""
        rows = np.array([getattr(self, name) for name in EXAMPLE_COLUMNS]).T
        return rows[np.lexsort((rows[:, 2], rows[:, 0]))]

    def __call__(
        self,
        sightings: Sightings,
        boxes: Float[Array, "n 4"],
        missed: Bool[Array, " n"],
        seed: int,
        step: float,
        level: float = 1.0,
    ) -> tuple[Int[Array, " k"], Float[Array, "k 4"], Float[Array, " k"]]:
        """The rows that have a second box, the boxes, and their scores.

        boxes: the first ones, as they are or would be reported.
        """
        rates = np.where(
            missed,
            np.interp(sightings.visible, VISIBLE_KNOTS, self.missed),
            np.interp(sightings.visible, VISIBLE_KNOTS, self.seen),
        )
        rates = np.where(sightings.visible > 0.0, np.minimum(level * rates, 1.0), 0.0)
        ids, frames = sightings.ids, sightings.frames
        rows = np.flatnonzero(
            bursts(rates, seed, "duplicate", ids, frames, self.autocorrelation, step)
        )
        if not len(rows):
            return rows, np.zeros((0, 4)), np.zeros(0)
        ids, frames = ids[rows], frames[rows]
        x = correlated_normals(seed, "duplicate/box", ids, frames, self.autocorrelation, step)
        chosen = self.examples[(ndtr(x[:, 0]) * len(self.dx)).astype(np.int64)]
        moved = move_boxes(boxes[rows], *chosen[:, :4].T)
        return rows, moved, expit(chosen[:, 4])

    def may_be_left_behind(
        self, sightings: Sightings, scores: Float[Array, " n"], seed: int, level: float = 1.0
    ) -> Int[Array, " k"]:
        """The rows whose box of before is reported too if it jumps; scores: of the boxes."""
        rate = np.where(scores < UNSURE_SCORE, self.at_unsure_jumps, self.at_jumps)
        chance = self._jump_draws(sightings, seed)[:, 0]
        return np.flatnonzero((chance < level * rate) & (sightings.visible > 0.0))

    def left_behind(
        self,
        sightings: Sightings,
        boxes: Float[Array, "n 4"],
        before: Float[Array, "n 4"],
        seed: int,
    ) -> tuple[Int[Array, " k"], Float[Array, " k"]]:
        """The rows of those that jump, and the scores of what they leave behind.

        Rows: as `may_be_left_behind` gives them; boxes: with their errors; before: the same with
        those of the frame before.
        """
        rows = np.flatnonzero(box_iou(boxes, before) < MAX_JUMP_IOU)
        which = self._jump_draws(sightings.select(rows), seed)[:, 1]
        picked = (which * len(self.dx)).astype(np.int64)
        return rows, expit(self.examples[picked, 4])

    def _jump_draws(self, sightings: Sightings, seed: int) -> Float[Array, "n 2"]:
        """Two uniform numbers a row."""
        return random_numbers.uniform(seed, "duplicate/jump", sightings.ids, sightings.frames, 2)


@dataclass(frozen=True)
class Splits:
    """Wide vehicles that are reported in two parts, side by side."""

    rate: float = 0.0
    """Rate at which a wide vehicle is split, 0 to 1; more: more second boxes."""
    min_width: float = 200.0
    """Width of the box, pixels, >= 0, from which a vehicle may be split; more: fewer splits."""
    autocorrelation: Autocorrelation = field(default_factory=Autocorrelation)
    """How splits are correlated over time; slower: a vehicle stays split longer."""

    def __post_init__(self) -> None:
        require_rates("splits", self.rate)
        require_sigmas("splits min_width", self.min_width)

    def __call__(
        self, sightings: Sightings, boxes: Float[Array, "n 4"], seed: int, step: float
    ) -> tuple[Int[Array, " k"], Float[Array, "k 4"], Float[Array, "k 4"]]:
        """The rows that are split, and the boxes of both parts."""
        wide = boxes[:, 2] - boxes[:, 0] >= self.min_width
        ids, frames = sightings.ids, sightings.frames
        rates = np.where(wide, self.rate, 0.0)
        rows = np.flatnonzero(bursts(rates, seed, "split", ids, frames, self.autocorrelation, step))
        share = (
            0.35 + 0.3 * random_numbers.uniform(seed, "split/where", ids[rows], frames[rows])[:, 0]
        )
        left, right = boxes[rows].copy(), boxes[rows].copy()
        split_at = left[:, 0] + share * (left[:, 2] - left[:, 0])
        left[:, 2], right[:, 0] = split_at, split_at
        return rows, left, right


@dataclass(frozen=True)
class Merges:
    """Cars that share one box with another."""

    rate: float = 0.0
    """Rate at which two overlapping cars become one box, 0 to 1; more: more cars lost in others."""
    min_iou: float = 0.3
    """IoU of the two boxes, 0 to 1, from which they may merge; more: fewer merges."""
    autocorrelation: Autocorrelation = field(default_factory=Autocorrelation)
    """How merges are correlated over time; slower: two cars stay merged longer."""

    def __post_init__(self) -> None:
        require_rates("merges", self.rate, self.min_iou)

    def __call__(
        self, sightings: Sightings, boxes: Float[Array, "n 4"], seed: int, step: float
    ) -> tuple[Int[Array, " k"], Int[Array, " k"], Float[Array, "k 4"]]:
        """Rows that keep a merged box, rows that vanish in it, and the boxes around both.

        A row takes part in one merge at most: the one that overlaps it most.
        """
        none = np.zeros(0, np.int64)
        if self.rate == 0.0 or not len(sightings):
            return none, none, np.zeros((0, 4))
        frames = sightings.frames
        first, second, iou = overlapping_pairs(frames, boxes, self.min_iou)
        order = np.argsort(-iou, kind="stable")
        first, second = first[order], second[order]
        keys = pair_ids(sightings.ids[first], sightings.ids[second])
        rates = np.full(len(order), self.rate)
        joined = np.flatnonzero(
            bursts(rates, seed, "merge", keys, frames[first], self.autocorrelation, step)
        )
        taken: set[int] = set()
        kept, gone = [], []
        for a, b in zip(first[joined].tolist(), second[joined].tolist(), strict=True):
            if a not in taken and b not in taken:
                taken |= {a, b}
                kept.append(a)
                gone.append(b)
        a_rows, b_rows = np.array(kept, np.int64), np.array(gone, np.int64)
        low = np.minimum(boxes[a_rows, :2], boxes[b_rows, :2])
        high = np.maximum(boxes[a_rows, 2:], boxes[b_rows, 2:])
        return a_rows, b_rows, np.concatenate((low, high), axis=1)

"""How boxes are off: an error for each of the four edges."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from mot_sim.simulation import random_numbers
from mot_sim.simulation.sensors.checks import require_finite, require_rates, require_sigmas
from mot_sim.simulation.sensors.correlated_noise import Autocorrelation, correlated_normal_columns
from mot_sim.simulation.sensors.sightings import Sightings
from tracker.errors import BadConfig

MAX_ERROR_SPREADS = 8.0  # typical errors, so that no box turns inside out
MIN_TAIL = 1e-6  # below, sinh is a straight line
MIN_SIDE_SHARE = 0.05  # of the true side; a smaller box is no box
USUAL_VISIBLE, USUAL_HEIGHT = 0.95, 50.0  # of a car (part, pixels) at which `spread` holds
HEIGHT_RANGE = (10.0, 300.0)  # pixels; smaller and larger cars are as those
MIN_SIDE_PIXELS = 5.0  # sides that are smaller count as so long for errors in pixels
MAX_HELD_FRAMES = 16  # in a row in which an error is held
UNSURE_SCORE = 0.9  # of a box, below which a detector is not sure of it
EDGES = ("left", "upper", "right", "lower")


@dataclass(frozen=True)
class EdgeNoise:
    """The error of one edge: bias + spread * shape(x), x a correlated standard normal number.

    In parts of the box's width for the left and the right edge, of its height for the others.
    """

    spread: float = 0.0
    """Typical size of the error, in parts of the side, >= 0; more: boxes jump more."""
    bias: float = 0.0
    """Mean of the error, in parts of the side; not 0: the edge is always off to one side."""
    bias_pixels: float = 0.0
    """Mean of the error in pixels, besides; not 0: small boxes are off more."""
    bias_hidden: float = 0.0
    """Adds bias_hidden * (0.95 - visible) to the mean; not 0: boxes of hidden cars are off to one
    side."""
    tail: float = 0.0
    """shape(x) = sinh(tail * x) / tail, >= 0; 0 is normal, more: more errors far from the mean."""
    skew: float = 0.0
    """Adds skew * (x^2 - 1) to shape(x); not 0: large errors lie on one side."""
    hidden: float = 0.0
    """`spread` grows by e^(hidden * (0.95 - visible)); more: larger errors of hidden cars."""
    by_height: float = 0.0
    """`spread` grows by (height / 50 px)^by_height; below 0: larger errors of small boxes."""
    by_extremes: float = 0.0
    """`spread` grows by e^(by_extremes * ln(height / 50 px)^2); more: larger errors of very small
    and of very large boxes."""
    unsure: float = 0.0
    """`spread` grows by e^(unsure * (1 - score)^.25); more: larger errors where scores are low."""
    autocorrelation: Autocorrelation = field(default_factory=Autocorrelation)
    """How x is correlated over time; slower: boxes drift instead of jumping."""

    def __post_init__(self) -> None:
        require_sigmas("jitter spread, tail", self.spread, self.tail)
        require_finite(
            "jitter bias, skew, ...", self.bias, self.bias_pixels, self.bias_hidden, self.skew,
            self.hidden, self.by_height, self.by_extremes, self.unsure,
        )  # fmt: skip

    def shape(self, x: Float[Array, " n"]) -> Float[Array, " n"]:
        """From a normal number to one with the edge's tails and skew."""
        stretched = np.sinh(self.tail * x) / self.tail if self.tail > MIN_TAIL else x
        return (stretched + self.skew * (x**2 - 1.0)).clip(-MAX_ERROR_SPREADS, MAX_ERROR_SPREADS)

    def mean(self, visible: Float[Array, " n"], side: Float[Array, " n"]) -> Float[Array, " n"]:
        """The mean error; side: length of the side that errors are parts of, pixels."""
        pixels = self.bias_pixels / np.maximum(side, MIN_SIDE_PIXELS)
        return self.bias + pixels + self.bias_hidden * (USUAL_VISIBLE - visible)

    def growth(
        self, visible: Float[Array, " n"], height: Float[Array, " n"], scores: Float[Array, " n"]
    ) -> Float[Array, " n"]:
        """What `spread` is multiplied with; height: of the box, pixels."""
        tall = np.log(height.clip(*HEIGHT_RANGE) / USUAL_HEIGHT)
        return np.exp(
            self.hidden * (USUAL_VISIBLE - visible)
            + self.by_height * tall
            + self.by_extremes * tall**2
            + self.unsure * doubt(scores)
        )


@dataclass(frozen=True)
class Jitter:
    """Errors of a box's edges."""

    left: EdgeNoise = field(default_factory=EdgeNoise)
    """Error of the left edge, in parts of the width; > 0: too far to the right."""
    upper: EdgeNoise = field(default_factory=EdgeNoise)
    """Error of the upper edge, in parts of the height; > 0: too low in the image."""
    right: EdgeNoise = field(default_factory=EdgeNoise)
    """Error of the right edge, in parts of the width."""
    lower: EdgeNoise = field(default_factory=EdgeNoise)
    """Error of the lower edge, in parts of the height."""
    horizontal: float = 0.0
    """Correlation of the left and the right edge's x, -1 to 1; more: boxes shift rather than
    stretch."""
    vertical: float = 0.0
    """Correlation of the upper and the lower edge's x, -1 to 1; likewise."""
    hold: float = 0.0
    """Seconds, >= 0, for which a box's errors stay as they are on average before they jump to
    where their autocorrelation has brought them meanwhile; 0: they move in every frame; more: boxes
    stand and jump."""
    unsteady: float = 0.0
    """Share of x's variance, 0 to 1, that is drawn anew in every frame where x is held; more: boxes
    tremble."""
    unsure_own: float = 0.0
    """Share of x's variance, 0 to 1, that boxes with a score below UNSURE_SCORE have of their own,
    as correlated over time as the rest; more: boxes jump where scores fall or rise."""

    def __post_init__(self) -> None:
        require_sigmas("jitter hold", self.hold)
        require_rates("jitter unsteady, unsure_own", self.unsteady, self.unsure_own)
        for name in ("horizontal", "vertical"):
            value = getattr(self, name)
            if not -1.0 <= value <= 1.0:
                raise BadConfig(f"jitter {name} {value:g}: a correlation lies in [-1, 1]")

    def __call__(
        self,
        boxes: Float[Array, "n 4"],
        sightings: Sightings,
        scores: Float[Array, " n"],
        seed: int,
        step: float,
        level: float = 1.0,
        back: int = 0,
    ) -> Float[Array, "n 4"]:
        """The boxes with their errors; level 0 gives them back unchanged.

        scores: by which errors go; back: 1: with the errors that they had in the frame before,
        with scores that are theirs there.
        """
        if not level >= 0.0:
            raise BadConfig(f"jitter level {level:g}: 0 (none) or more")
        if level == 0.0 or self._does_nothing:
            return boxes
        x = self._normals(sightings, scores, seed, step, back)
        for first, second, shared in ((0, 2, self.horizontal), (1, 3, self.vertical)):
            if shared != 0.0:
                x[:, second] *= np.sqrt(1.0 - shared**2)
                x[:, second] += shared * x[:, first]
        sides = boxes[:, 2:] - boxes[:, :2]
        visible, height = sightings.visible, sightings.height
        errors = [
            edge.mean(visible, sides[:, place % 2])
            + edge.spread * edge.growth(visible, height, scores) * edge.shape(x[:, place])
            for place, edge in enumerate(self.edges)
        ]
        return move_edges(boxes, level * np.stack(errors, axis=1))

    def _normals(
        self,
        sightings: Sightings,
        scores: Float[Array, " n"],
        seed: int,
        step: float,
        back: int,
    ) -> Float[Array, "n 4"]:
        """What the errors are made of; see `__call__`."""
        ids, frames = sightings.ids, np.maximum(sightings.frames - back, 0)
        how = self.autocorrelations, step, self.hold, self.unsteady
        x = held_normals(seed, "jitter", ids, frames, *how)
        unsure = np.flatnonzero(scores < UNSURE_SCORE) if self.unsure_own > 0.0 else ids[:0]
        if len(unsure):
            own = held_normals(seed, "jitter/unsure", ids[unsure], frames[unsure], *how)
            x[unsure] = np.sqrt(1.0 - self.unsure_own) * x[unsure] + np.sqrt(self.unsure_own) * own
        return x

    @cached_property
    def edges(self) -> tuple[EdgeNoise, ...]:
        """The four, in the order of a box's numbers."""
        return self.left, self.upper, self.right, self.lower

    @cached_property
    def autocorrelations(self) -> tuple[Autocorrelation, ...]:
        """Of the four; of the right and the lower one of what they do not share."""
        return tuple(edge.autocorrelation for edge in self.edges)

    @cached_property
    def _does_nothing(self) -> bool:
        return not any(
            (edge.spread, edge.bias, edge.bias_pixels, edge.bias_hidden) != (0.0,) * 4
            for edge in self.edges
        )


def doubt(scores: Float[Array, " n"]) -> Float[Array, " n"]:
    """What errors grow with where scores fall, 0 to 1: fast below 1, slowly further down."""
    return (1.0 - scores).clip(0.0, 1.0) ** 0.25


def held_normals(
    seed: int,
    effect: str,
    ids: Int[Array, " n"],
    frames: Int[Array, " n"],
    autocorrelations: tuple[Autocorrelation, ...],
    step: float,
    hold: float,
    unsteady: float,
) -> Float[Array, "n k"]:
    """Correlated normal numbers that stay for a while and then jump; see `Jitter.hold`.

    A number that is held is that of the frame in which it was last renewed. Renewals are drawn
    frame by frame, the same for all effects, and one of MAX_HELD_FRAMES in a row is always one.
    """
    if hold == 0.0:
        return correlated_normal_columns(seed, effect, ids, frames, autocorrelations, step)
    when = np.maximum(frames[:, None] - np.arange(MAX_HELD_FRAMES), 0)
    owner = np.repeat(ids, MAX_HELD_FRAMES)
    drawn = random_numbers.uniform(seed, "jitter/hold", owner, when.ravel())
    renewed = drawn.reshape(when.shape) < -np.expm1(-step / hold)
    turn = random_numbers.bits(seed, "jitter/turn", ids, np.zeros_like(ids))
    turn = (turn % np.uint64(MAX_HELD_FRAMES)).astype(np.int64)
    renewed |= ((when - turn) % MAX_HELD_FRAMES == 0) | (when == 0)
    last = np.maximum(frames - renewed.argmax(axis=1), 0)
    x = correlated_normal_columns(seed, effect, ids, last, autocorrelations, step)
    if unsteady > 0.0:
        anew = random_numbers.normal(seed, f"{effect}/anew", ids, frames, x.shape[1])
        x = np.sqrt(1.0 - unsteady) * x + np.sqrt(unsteady) * anew
    return x


def move_edges(boxes: Float[Array, "n 4"], errors: Float[Array, "n 4"]) -> Float[Array, "n 4"]:
    """Boxes with moved edges, in parts of the sides; none becomes smaller than MIN_SIDE_SHARE."""
    sides = boxes[:, 2:] - boxes[:, :2]
    moved = boxes + errors * np.tile(sides, 2)
    short = 0.5 * (MIN_SIDE_SHARE * sides - (moved[:, 2:] - moved[:, :2]))
    short = np.maximum(short, 0.0)
    return moved + np.concatenate((-short, short), axis=1)


def edge_errors(boxes: Float[Array, "n 4"], true: Float[Array, "n 4"]) -> Float[Array, "n 4"]:
    """What `move_edges` needs to make the boxes from the true ones."""
    return (boxes - true) / np.tile(true[:, 2:] - true[:, :2], (1, 2))


def edges_of_centre(centre: EdgeNoise, size: EdgeNoise) -> tuple[EdgeNoise, EdgeNoise, float]:
    """The two edges whose centre and log-size have these errors, nearly, and their correlation.

    For profiles of version 1, which had errors of centre and size.
    """
    parts = np.array([centre.spread**2, 0.25 * size.spread**2])
    whole = float(parts.sum())
    shares = parts / whole if whole > 0.0 else np.array([0.5, 0.5])

    def mixed(name: str) -> float:
        return float(shares @ [getattr(centre, name), getattr(size, name)])

    slow = [centre.autocorrelation, size.autocorrelation]
    pieces = [
        (share * part, tau, float(smooth))
        for share, each in zip(shares.tolist(), slow, strict=True)
        for part, tau, smooth in each.parts
    ]
    autocorrelation = Autocorrelation(*(tuple(column) for column in zip(*pieces, strict=True)))
    edges = [
        EdgeNoise(
            spread=whole**0.5,
            bias=centre.bias + side * 0.5 * size.bias,
            tail=mixed("tail"),
            skew=float(shares[0]) * centre.skew + side * float(shares[1]) * size.skew,
            hidden=mixed("hidden"),
            by_height=mixed("by_height"),
            autocorrelation=autocorrelation,
        )
        for side in (-1.0, 1.0)
    ]
    return edges[0], edges[1], float(shares[0] - shares[1])

"""Fits a camera's look to photographs: drawn frames get the photographs' statistics."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple, dataclass, replace

import numpy as np
from jaxtyping import Float, UInt8
from numpy import ndarray as Array
from scipy.optimize import least_squares

from mot_sim.simulation.camera_looks.developing import develop
from mot_sim.simulation.camera_looks.image_statistics import (
    STATISTICS,
    ImageStatistics,
    mean_statistics,
)
from mot_sim.simulation.camera_looks.look import CameraLook
from tracker.errors import BadConfig
from tracker.types import Camera

Image = UInt8[Array, "h w 3"]
# The knobs that are fitted, with their least and most; others stay as they were given.
FITTED_KNOBS: dict[str, tuple[float, float]] = {
    "lens.blur": (0.45, 1.2), "exposure.mean": (60.0, 130.0), "exposure.red": (0.85, 1.15),
    "exposure.blue": (0.85, 1.15), "tone.contrast": (1.2, 2.8), "tone.saturation": (0.6, 1.1),
    "tone.black": (0.0, 12.0), "sensor.full_well": (0.8, 1.8), "sensor.read_noise": (0.0, 2.0),
    "sensor.shot_noise": (0.0, 0.3),
}  # fmt: skip
STEP_SHARE = 0.04  # of a knob's range, by which it is moved to see what it does
INSIDE_WEIGHT = 0.15  # of a statistic's place inside its range, beside what lies outside
# Least half widths of ranges, so that none rules the fit: in the statistics' own units.
MIN_HALF_WIDTHS = ImageStatistics(1.5, 3.0, 1.5, 6.0, 1.5, 0.5, 0.05, 12.0, 0.1, 0.1, 0.15)
MAX_FIT_STEPS = 12
# Texture, which no camera adds: were it fitted, noise and exposure would stand in for it.
NOT_FITTED = ("gradient",)


@dataclass(frozen=True, eq=False)
class DrawnFrame:
    """A frame as it reaches the camera, drawn and under its weather."""

    image: Image
    """RGB, without a camera's noise, vignetting and JPEG."""
    camera: Camera
    """That it is seen by."""
    seed: int
    """Random seed of its run, for the noise."""
    frame: int
    """Its number in the run, from 0."""

    def developed(self, look: CameraLook) -> Image:
        """What a look makes of it."""
        return develop(self.image, self.camera, look, self.seed, self.frame)


@dataclass(frozen=True)
class StatisticsRange:
    """From where to where each statistic of photographs goes."""

    least: ImageStatistics
    """The least of each."""
    most: ImageStatistics
    """The most of each."""

    @classmethod
    def of(cls, clips: Sequence[ImageStatistics]) -> "StatisticsRange":
        """Of the means of several clips. Raises BadConfig for none."""
        if not clips:
            raise BadConfig("no photographs: give one folder of images or more")
        rows = np.array([astuple(clip) for clip in clips])
        least, most = np.fmin.reduce(rows), np.fmax.reduce(rows)
        return cls(ImageStatistics(*least.tolist()), ImageStatistics(*most.tolist()))

    def holds(self, name: str, value: float) -> bool:
        """Whether a value of a statistic lies in the range."""
        return bool(getattr(self.least, name) <= value <= getattr(self.most, name))


def fit_look(
    look: CameraLook,
    scenes: Mapping[str, Sequence[DrawnFrame]],
    wanted: StatisticsRange,
    progress: Callable[[], None] | None = None,
) -> CameraLook:
    """The look whose knobs bring the statistics of all scenes nearest to their ranges.

    look: where the search begins; knobs that FITTED_KNOBS does not name stay as they are there.
    progress: called after every try. The same input gives the same look.
    """
    least, most = np.array(list(FITTED_KNOBS.values())).T
    begin = (np.array([knob_of(look, name) for name in FITTED_KNOBS]) - least) / (most - least)

    def missed(shares: Float[Array, " k"]) -> Float[Array, " r"]:
        tried = with_knobs(look, least + shares * (most - least))
        if progress is not None:
            progress()
        return np.concatenate([distances(wanted, frames, tried) for frames in scenes.values()])

    found = least_squares(
        missed,
        np.clip(begin, 0.01, 0.99),
        bounds=(np.zeros(len(least)), np.ones(len(least))),
        diff_step=STEP_SHARE,
        loss="soft_l1",
        max_nfev=MAX_FIT_STEPS,
    )
    return with_knobs(look, np.round(least + found.x * (most - least), 4))


def distances(
    wanted: StatisticsRange, frames: Sequence[DrawnFrame], look: CameraLook
) -> Float[Array, " s"]:
    """How far each statistic lies outside its range, in half widths; a little for its place in it.

    A statistic of NOT_FITTED, without a range, or that cannot be measured, counts nothing.
    """
    seen = np.array(astuple(mean_statistics(each.developed(look) for each in frames)))
    least, most = (np.array(astuple(one)) for one in (wanted.least, wanted.most))
    half = np.maximum(0.5 * (most - least), astuple(MIN_HALF_WIDTHS))
    outside = np.maximum(least - seen, 0.0) - np.maximum(seen - most, 0.0)
    apart = outside / half + INSIDE_WEIGHT * (0.5 * (least + most) - seen) / half
    counts = np.array([name not in NOT_FITTED for name in STATISTICS])
    return np.where(np.isfinite(apart) & counts, apart, 0.0)


def knob_of(look: CameraLook, name: str) -> float:
    """The value of a knob by its dotted name."""
    part, _, knob = name.partition(".")
    return float(getattr(getattr(look, part), knob))


def with_knobs(look: CameraLook, values: Float[Array, " k"]) -> CameraLook:
    """The look with the values of FITTED_KNOBS, in their order."""
    for name, value in zip(FITTED_KNOBS, values.tolist(), strict=True):
        part, _, knob = name.partition(".")
        look = replace(look, **{part: replace(getattr(look, part), **{knob: value})})
    return look


__all__ = [
    "FITTED_KNOBS",
    "STATISTICS",
    "DrawnFrame",
    "StatisticsRange",
    "fit_look",
]

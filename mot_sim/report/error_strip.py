"""How far tracks stand off their cars, over time: a strip below the view from above."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.metrics.cuboid_errors import CuboidErrors, cuboid_errors
from mot_sim.plotting.canvas import Image, draw_line, draw_text, text_width
from mot_sim.plotting.colours import FAINT_COLOUR, PANEL_COLOUR, TEXT_COLOUR, colour_of_id, mix
from tracker.types import Tracks

STRIP_PIXELS = 92
LEFT_PIXELS = 34  # for the numbers of the axis
RIGHT_PIXELS = 250  # for what holds now
TOP_PIXELS, BOTTOM_PIXELS = 9, 20  # above the axis and below it
LINE_PIXELS = 20  # from line to line of the words
TICK_SECONDS = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
MAX_TICKS = 12
MAX_METRES = 6.0  # where the axis ends
TICK_METRES = (0.0, 2.0, 4.0, 6.0)
TRACK_DIMMING = 0.25
SIGMAS = 2.0
MIN_LINE_FRAMES = 2  # a gap from which on a line is broken


@dataclass(frozen=True, eq=False)
class ErrorStrip:
    """The errors of one film, drawn up to a frame."""

    errors: CuboidErrors
    """A row per label that a track meets in the image."""
    frame_count: int
    """Frames from the left end of the axis to the right one."""
    width: int
    """Of the strip, px."""
    frame_rate: float = 10.0
    """Hz; the axis has seconds."""

    @classmethod
    def of(
        cls,
        truth: Tracks | None,
        tracks: Tracks,
        frame_count: int,
        width: int,
        frame_rate: float,
        kind: str = "Car",
    ) -> "ErrorStrip | None":
        """The strip of a film; None where labels or tracks have no cuboids."""
        if truth is None or truth.cuboids is None or tracks.cuboids is None:
            return None
        found = cuboid_errors(truth, tracks, frame_count, kind=kind)
        known = found.select(np.isfinite(found.centre))
        return cls(known, frame_count, width, frame_rate) if len(known) else None

    def draw(self, index: int) -> Image:
        """The errors of all frames up to this one: of each track in its colour, and medians."""
        image = self._axes.copy()
        for name, (frames, metres) in self._by_track.items():
            count = int(np.searchsorted(frames, index, side="right"))
            colour = mix(colour_of_id(name), PANEL_COLOUR, TRACK_DIMMING)
            for line in self._lines(frames[:count], metres[:count]):
                draw_line(image, line, colour)
        frames, medians = self._medians
        count = int(np.searchsorted(frames, index, side="right"))
        for line in self._lines(frames[:count], medians[:count]):
            draw_line(image, line, TEXT_COLOUR, 2)
        self._write_words(image, index)
        return image

    def _write_words(self, image: Image, index: int) -> None:
        """What holds now, and so far."""
        errors = self.errors
        past, now = errors.centre[errors.frames <= index], errors.centre[errors.frames == index]
        words = [f"now {np.median(now):.1f} m, {len(now)} tracks" if len(now) else "now none"]
        if len(past):
            middle, worst = np.quantile(past, (0.5, 0.9))
            words.append(f"so far {middle:.1f} m, 90 %: {worst:.1f} m")
            stated = errors.stated.centre[errors.frames <= index]
            stated = stated[np.isfinite(stated)]
            if len(stated):
                inside = 100.0 * (stated <= SIGMAS**2).mean()
                words.append(f"inside 2 sigma: {inside:.0f} % (ideal 86)")
        for number, line in enumerate(words, 2):
            place = (self.width - RIGHT_PIXELS + 12, LINE_PIXELS * number)
            draw_text(image, line, place, TEXT_COLOUR, 13)

    @cached_property
    def _by_track(self) -> dict[int, tuple[Float[Array, "_"], Float[Array, "_"]]]:
        """Frames, in order, and errors of each track."""
        found = {}
        for name in np.unique(self.errors.output_ids).tolist():
            rows = np.flatnonzero(self.errors.output_ids == name)
            rows = rows[np.argsort(self.errors.frames[rows], kind="stable")]
            found[name] = self.errors.frames[rows].astype(float), self.errors.centre[rows]
        return found

    @cached_property
    def _medians(self) -> tuple[Float[Array, " n"], Float[Array, " n"]]:
        """Frames with a car, and the median error in each."""
        frames = np.unique(self.errors.frames)
        medians = [np.median(self.errors.centre[self.errors.frames == each]) for each in frames]
        return frames.astype(float), np.array(medians)

    @cached_property
    def _axes(self) -> Image:
        """The strip without errors."""
        image = np.empty((STRIP_PIXELS, self.width, 3), np.uint8)
        image[:] = PANEL_COLOUR
        faint = mix(PANEL_COLOUR, FAINT_COLOUR, 0.35)
        for metres in TICK_METRES:
            line = self._points(np.array([0.0, self.frame_count - 1.0]), np.full(2, metres))
            draw_line(image, line, faint)
            word = f"{metres:.0f} m" if metres == TICK_METRES[-1] else f"{metres:.0f}"
            draw_text(image, word, (4, round(float(line[0, 1])) + 4), FAINT_COLOUR, 12)
        seconds = (self.frame_count - 1) / self.frame_rate
        step = next((each for each in TICK_SECONDS if seconds <= each * MAX_TICKS), seconds)
        for tick in np.arange(step, seconds + 1e-9, step) if step else ():
            line = self._points(np.full(2, tick * self.frame_rate), np.array([0.0, MAX_METRES]))
            draw_line(image, line, faint)
            word, u = f"{tick:g} s", round(float(line[0, 0]))
            draw_text(image, word, (u - text_width(word, 12) // 2, STRIP_PIXELS - 5), FAINT_COLOUR,
                      12)  # fmt: skip
        place = (self.width - RIGHT_PIXELS + 12, LINE_PIXELS)
        draw_text(image, "metres off the truth; white: median", place, FAINT_COLOUR, 12)
        return image

    def _points(
        self, frames: Float[Array, " n"], metres: Float[Array, " n"]
    ) -> Float[Array, "n 2"]:
        """Where errors lie in the strip."""
        across = (self.width - LEFT_PIXELS - RIGHT_PIXELS) / max(self.frame_count - 1, 1)
        down = (STRIP_PIXELS - TOP_PIXELS - BOTTOM_PIXELS) / MAX_METRES
        height = STRIP_PIXELS - BOTTOM_PIXELS - down * np.minimum(metres, MAX_METRES)
        return np.stack((LEFT_PIXELS + across * frames, height), axis=1)

    def _lines(
        self, frames: Float[Array, " n"], metres: Float[Array, " n"]
    ) -> list[Float[Array, "_ 2"]]:
        """Points of a line, cut where frames lack."""
        cuts = np.flatnonzero(np.diff(frames) > MIN_LINE_FRAMES) + 1
        return np.split(self._points(frames, metres), cuts)

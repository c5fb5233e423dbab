"""The one flat tree of errors: every message says what, the value, where, and the cure."""

from collections.abc import Iterable
from difflib import get_close_matches


class TrackingError(Exception):
    """Base of everything that a user of this project can do wrong."""


class BadCalibration(TrackingError):
    """A camera that cannot be: K transposed, a mirrored mount, no height, no image."""


class BadMotion(TrackingError):
    """A motion of the camera that cannot be: no rigid transform, faster than any car, NaN."""


class BadDetections(TrackingError):
    """Boxes or scores that no detector can mean: NaN, inverted, of different lengths."""


class BadImage(TrackingError):
    """An image that is not RGB with 8 bits, or not of the calibration's size."""


class BadWeights(TrackingError):
    """A model file that is missing, damaged, or of another model."""


class BadTracks(TrackingError):
    """Track rows that contradict each other: one id twice in a frame."""


class BadConfig(TrackingError):
    """A parameter outside its range, or parameters that contradict each other."""


class MissingCue(TrackingError):
    """A cost asks for a column that these detections do not have."""


class UnknownName(TrackingError):
    """A name that no registry knows."""

    @classmethod
    def of(cls, what: str, name: str, known: Iterable[str]) -> "UnknownName":
        """The error with the known names and the nearest of them."""
        names = sorted(known)
        close = get_close_matches(name, names, n=1, cutoff=0.5)
        hint = f". Did you mean '{close[0]}'?" if close else ""
        return cls(f"unknown {what} '{name}'; known: {', '.join(names)}{hint}")


class DatasetNotFound(TrackingError):
    """A data root, a sequence or one of its files is not there."""


class BadFile(TrackingError):
    """A file that does not hold what its format promises; names the file and the line."""


class OutputExists(TrackingError):
    """Results stand where new ones would go."""


class BadOutput(TrackingError):
    """A place that cannot be written to."""


class WorkersLost(TrackingError):
    """Those who do the work cannot be reached, or went away."""


class NoOpenGL(TrackingError):
    """No OpenGL context can be had here; says what is missing."""


class NoTorch(TrackingError):
    """PyTorch is not installed, and something is to be trained."""


class NoNumba(TrackingError):
    """Numba, which compiles the inner loops, is missing or of a version that does not fit."""


class KernelWarning(UserWarning):
    """Compiled code cannot be kept anywhere; says where it should have been."""


class MotionWarning(UserWarning):
    """The boxes contradict the motion or the calibration; says the likely mistake."""

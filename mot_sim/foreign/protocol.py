"""How a tracker is asked, whoever wrote it: anything with `step` or `update` becomes `Steps`."""

import sys
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from inspect import Parameter, signature
from typing import Any, Protocol, runtime_checkable

from mot_sim.files.fingerprint import PACKAGES
from mot_sim.files.named_objects import TRACKER_NAMES, make_tracker
from mot_sim.foreign.answers import tracks_from
from mot_sim.foreign.live import ExternalOnlineTracker
from mot_sim.foreign.register import GUESTS
from tracker import Camera, Frame, Tracker, Tracks
from tracker.errors import BadConfig, UnknownName

FRAME_RATE = 10.0  # Hz, of scenes
LIBRARIES = ("motpy", "norfair", "supervision", "trackers")  # a file of adapters/ each
IMAGE_NAMES = ("image", "img", "frame")  # of a third argument that is no setting
FORMS = (
    "step(frame), update(boxes, scores), update(boxes, scores, image), update(detections) with "
    "supervision's Detections, update(detections=None) with norfair's or step(detections) with "
    "motpy's"
)


@runtime_checkable
class Steps(Protocol):
    """A tracker: one frame in, the rows of that frame out.

    One that also has `finish()` decides later: `step` may give rows of earlier frames, and
    `finish` the rest.
    """

    def step(self, frame: Frame) -> Tracks:
        """The identities of this frame."""
        ...


@dataclass(eq=False)
class ForeignTracker:
    """A tracker of somebody's own, asked in its own way; its answers are Tracks."""

    inner: Any
    """The tracker."""
    ask: Callable[[Frame], Any]
    """What it answers to a frame, in any form that `tracks_from` reads."""

    def step(self, frame: Frame) -> Tracks:
        """The rows of this frame. Raises BadRows for an answer that cannot be read."""
        return tracks_from(self.ask(frame), frame)


@dataclass(eq=False)
class LateForeignTracker(ForeignTracker):
    """One that decides later: the rows of earlier frames come as Tracks."""

    def finish(self) -> Tracks:
        """The rows that are left."""
        found: Tracks = self.inner.finish()
        return found


def has_call(tracker: Any, name: str) -> bool:
    """Whether it has a method of that name."""
    return callable(getattr(tracker, name, None))


def as_steps(made: Any, name: str, frame_rate: float = FRAME_RATE) -> Steps:
    """A tracker as something with `step(frame)`; ours stay what they are.

    made: an object with `step(frame)`; `update(boxes, scores)` or `update(boxes, scores, image)`
    with boxes (n, 4) in pixels, scores (n,) and the image or None, all of them copies;
    `update(detections)`, which is given supervision's Detections; `update(detections=None)`, which
    is given norfair's; `step(detections)`, which is given motpy's; or a tracker of one of these
    libraries or of `trackers`. frame_rate: Hz. Raises BadConfig for what has none of these.
    """
    is_ours = isinstance(made, Tracker) or type(made).__module__.partition(".")[0] in PACKAGES
    if is_ours and has_call(made, "step"):
        return made
    late = LateForeignTracker if has_call(made, "finish") else ForeignTracker
    library = library_of(type(made))
    if library is not None:
        return _adapted(library, made, frame_rate)
    if has_call(made, "step"):
        if _arguments(made.step)[:1] == ["detections"]:
            return _adapted("motpy", made, frame_rate)
        return late(made, made.step)
    if has_call(made, "update"):
        return _updated(made, name, frame_rate, late)
    raise BadConfig(
        f"tracker {name}: a {type(made).__name__} is no tracker: it has neither step(frame) nor "
        f"update(boxes, scores); the forms: {FORMS}"
    )


def make_steps(
    made_by: str,
    camera: Camera,
    frame_rate: float = FRAME_RATE,
    name: str | None = None,
    **settings: Any,
) -> Steps:
    """A fresh tracker: one of GUESTS, or what a name of TRACKER_NAMES or MODULE:CALLABLE makes.

    name: what errors call it. settings: arguments of the callable. Raises UnknownName and
    BadConfig.
    """
    if made_by in GUESTS:
        for key in settings:
            if key != "min_score":
                raise UnknownName.of(f"setting of guest {made_by}:", key, ["min_score"])
        return ExternalOnlineTracker(made_by, frame_rate, **settings)
    told = name or made_by
    found = made_by_library(TRACKER_NAMES.find(made_by), told, frame_rate, settings)
    if found is not None:
        return found
    return as_steps(make_tracker(made_by, camera, **settings), told, frame_rate)


def made_by_library(
    kind: Any, name: str, frame_rate: float, settings: dict[str, Any]
) -> Steps | None:
    """A tracker of a library's own class with these settings; None: the class is of none.

    The library's adapter adds what the class needs: the frame rate, a distance of boxes.
    """
    library = library_of(kind) if isinstance(kind, type) else None
    if library is None:
        return None
    try:
        return _of_adapter(_adapter(library)(kind, frame_rate, settings))
    except TypeError as error:
        raise BadConfig(f"tracker {name} cannot be built: {error}") from None


def library_of(kind: type) -> str | None:
    """The library of LIBRARIES that a class, or one that it is made of, comes from."""
    for each in kind.__mro__:
        top = each.__module__.partition(".")[0]
        # A file of the user's own may have such a name; a library is a folder.
        if top in LIBRARIES and hasattr(sys.modules.get(top), "__path__"):
            return top
    return None


def _adapter(library: str) -> Any:
    return import_module(f"{__package__}.adapters.{library}_package").ADAPTER


def _of_adapter(adapter: Any) -> ForeignTracker:
    """What an adapter drives; see `PackageAdapter` in adapters/run.py."""

    def ask(frame: Frame) -> Any:
        seen = frame.found
        boxes = [
            [*box, score]
            for box, score in zip(seen.boxes.tolist(), seen.scores.tolist(), strict=True)
        ]
        answer = adapter.update(adapter.detections(boxes))
        if not _is_native(answer):
            return answer
        return [(*row[1:5], row[0]) for row in adapter.rows(answer)]

    return ForeignTracker(adapter.tracker, ask)


def _adapted(library: str, made: Any, frame_rate: float) -> ForeignTracker:
    """A ready tracker, asked as those of the library are. Raises BadConfig without the library."""
    package = "supervision" if library == "trackers" else library
    if find_spec(package) is None:
        raise BadConfig(
            f"a {type(made).__name__} takes {package}'s detections: pip install {package}, or "
            "write update(boxes, scores)"
        )
    return _of_adapter(_adapter(library)(lambda **_: made, frame_rate, {}))


def _is_native(answer: Any) -> bool:
    """Whether an answer is made of a library's own objects, and not of rows."""
    return isinstance(answer, list) and bool(answer) and hasattr(answer[0], "id")


def _updated(made: Any, name: str, frame_rate: float, late: type[ForeignTracker]) -> ForeignTracker:
    """A tracker with `update`, asked as its arguments say."""
    arguments = _arguments(made.update)
    if arguments[:1] == ["detections"]:
        optional = signature(made.update).parameters["detections"].default is not Parameter.empty
        return _adapted("norfair" if optional else "trackers", made, frame_rate)
    if len(arguments) == 1:
        raise BadConfig(
            f"tracker {name}: update({arguments[0]}) takes one argument that is not called "
            f"`detections`; the forms: {FORMS}"
        )
    wants_image = _wants_image(made.update)

    def ask(frame: Frame) -> Any:
        seen = frame.found
        given = (seen.boxes.copy(), seen.scores.copy())
        if not wants_image:
            return made.update(*given)
        return made.update(*given, None if frame.image is None else frame.image.copy())

    return late(made, ask)


def _arguments(method: Callable[..., Any]) -> list[str]:
    """What can be given by place, or is called `detections`; none where nothing is known of it."""
    try:
        parameters = signature(method).parameters.values()
    except (TypeError, ValueError):  # of a builtin
        return []
    by_place = (Parameter.POSITIONAL_ONLY, Parameter.POSITIONAL_OR_KEYWORD)
    return [each.name for each in parameters if each.kind in by_place or each.name == "detections"]


def _wants_image(method: Callable[..., Any]) -> bool:
    """Whether a third argument is an image: it must be given, or is called so."""
    arguments = _arguments(method)
    if len(arguments) < 3:
        return False
    third = signature(method).parameters[arguments[2]]
    return third.default is Parameter.empty or third.name in IMAGE_NAMES


__all__ = [
    "FRAME_RATE",
    "LIBRARIES",
    "ForeignTracker",
    "Steps",
    "as_steps",
    "has_call",
    "made_by_library",
    "make_steps",
]

"""Any tracker over an episode: its rows, checked; whatever goes wrong has a name."""

import inspect
from typing import Any

from mot_sim.experiments.sweep.seeded_episodes import SeededEpisode
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.experiments.sweep.trial import require_rows, wrong_motion_allowed
from mot_sim.foreign.answers import BadRows
from mot_sim.foreign.protocol import FRAME_RATE, Steps, as_steps, has_call, made_by_library
from tracker import Camera, Tracks
from tracker.errors import BadConfig, TrackingError


class TrackerFailed(TrackingError):
    """A tracker that raised, or gave what cannot be scored; frame: which, None: not in one."""

    def __init__(self, tracker: str, where: str, reason: str, frame: int | None) -> None:
        super().__init__(f"tracker {tracker} failed {where}: {reason}")
        self.frame = frame


def follow(tracker: Any, episode: SeededEpisode) -> Tracks:
    """All rows that a tracker gives for an episode; it is given frames and nothing else.

    tracker: an object with `step` or `update`, see `as_steps` for their forms, and `tracks_from`
    for those of their answers; a class or function that makes one, and is given the camera if it
    takes a `camera`; or words as for `mot-sim sweep --trackers`. One
    that has `reset()` is reset first, one that has `finish()` decides later. Raises BadConfig for
    what is no tracker, TrackerFailed when it raises, or gives NaN, an id twice or a wrong shape.
    """
    name = name_of(tracker)
    stepping = stepping_of(tracker, episode.camera)
    is_late = callable(getattr(stepping, "finish", None))
    came: list[int] = []
    parts: list[Tracks] = []
    where, frame = "before the first frame", None
    try:
        with wrong_motion_allowed():
            for given in episode.frames:
                frame, where = given.index, f"in frame {given.index}"
                came.append(given.index)
                parts.append(_checked(stepping.step(given), came if is_late else came[-1:]))
        if is_late:
            frame, where = None, "after the last frame"
            parts.append(_checked(stepping.finish(), came))  # type: ignore[attr-defined]
        return _checked(Tracks.concatenate(parts) if parts else Tracks.empty(), came)
    except BadRows as error:
        raise TrackerFailed(name, where, str(error), frame) from None
    except (Exception, SystemExit) as error:
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        raise TrackerFailed(name, where, reason, frame) from error


def stepping_of(tracker: Any, camera: Camera) -> Steps:
    """The tracker as something with `step`, reset where it can be; see `follow`."""
    if isinstance(tracker, str):
        return TrackerSpec.parse(tracker).build(camera)
    name = name_of(tracker)
    if isinstance(tracker, type):
        found = made_by_library(tracker, name, FRAME_RATE, {})
        if found is not None:
            return found
    if isinstance(tracker, type) or not (has_call(tracker, "step") or has_call(tracker, "update")):
        tracker = _made(tracker, camera)
    elif has_call(tracker, "reset"):
        tracker.reset()
    return as_steps(tracker, name)


def _made(make: Any, camera: Camera) -> Any:
    """What a class or function makes; the thing itself where it cannot be called."""
    if not callable(make):
        return make
    try:
        takes_camera = "camera" in inspect.signature(make).parameters
    except ValueError:  # of a builtin
        takes_camera = False
    try:
        return make(camera) if takes_camera else make()
    except TypeError as error:
        raise BadConfig(
            f"tracker {name_of(make)} cannot be built: {error}; give a ready tracker, or what "
            "makes one from nothing or from a `camera`"
        ) from None


def name_of(tracker: Any) -> str:
    """What messages call a tracker."""
    if isinstance(tracker, str):
        return tracker
    return getattr(tracker, "__qualname__", None) or type(tracker).__qualname__


def _checked(rows: Any, allowed: list[int]) -> Tracks:
    """The rows; BadRows where they cannot be scored."""
    require_rows(rows, allowed)
    found: Tracks = rows
    return found


__all__ = ["TrackerFailed", "follow"]

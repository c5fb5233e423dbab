"""One trial: a tracker over one drive, its output checked, then scored; what fails is said."""

from collections import Counter
from dataclasses import dataclass, field
from time import thread_time

import numpy as np

from mot_sim.experiments.sweep.drives import TrialSequence
from mot_sim.experiments.sweep.tracker_specs import BadRows, TrackerSpec
from mot_sim.metrics import evaluate_sequence
from tracker import Tracks

MOST_WORDS = 300  # letters of an error that are kept


@dataclass(frozen=True, eq=False)
class TrialOutcome:
    """What came of a trial. scores: by TrackEval's names; none where there is an error.

    frames: that came. detections: in them. cpu_seconds: of tracking; the only value that differs
    from run to run.
    """

    scores: dict[str, int | float] = field(default_factory=dict)
    error: str | None = None
    frames: int = 0
    detections: int = 0
    cpu_seconds: float = 0.0


def run_trial(
    contender: TrackerSpec, drive: TrialSequence, rules: str = "trackeval"
) -> TrialOutcome:
    """Track and score; whatever a tracker raises, or gives that is no output, is the error."""
    start, detections = thread_time(), 0
    came: list[int] = []
    parts: list[Tracks] = []
    at = "before the first frame"
    try:
        tracker = contender.build(drive.sequence.camera)
        is_late = callable(getattr(tracker, "finish", None))
        for frame in drive.sequence:
            at = f"frame {frame.index}"
            detections += len(frame.detections)
            came.append(frame.index)
            parts.append(tracker.step(frame))
            require_rows(parts[-1], came if is_late else came[-1:])
        if is_late:
            at = "after the last frame"
            parts.append(tracker.finish())  # type: ignore[attr-defined]
            require_rows(parts[-1], came)
        output = Tracks.concatenate(parts) if parts else Tracks.empty()
        seconds = thread_time() - start
        at = "in the end"
        require_rows(output, came)
        at = "scoring"
        scores = evaluate_sequence(drive.truth, output, drive.frame_count, rules)
    except (Exception, SystemExit) as error:  # noqa: BLE001
        kind = "" if isinstance(error, BadRows) else f"{type(error).__name__}: "
        words = " ".join(f"{at}: {kind}{error}".split())[:MOST_WORDS]
        return TrialOutcome({}, words, len(came), detections, thread_time() - start)
    numbers = {name: _plain(number) for name, number in scores.numbers().items()}
    return TrialOutcome(numbers, None, len(came), detections, seconds)


def require_rows(rows: object, allowed: list[int]) -> None:
    """Raise BadRows for what is no output: another type, shape or frame, NaN, an id twice."""
    if not isinstance(rows, Tracks):
        raise BadRows(f"the tracker gave a {type(rows).__name__}, not Tracks")
    ids, boxes = np.asarray(rows.ids), np.asarray(rows.boxes)
    n = len(ids) if ids.ndim == 1 else -1
    if boxes.shape != (n, 4) or np.shape(rows.frames) != (n,):
        raise BadRows(
            f"wrong shape: ids {ids.shape}, frames {np.shape(rows.frames)}, boxes {boxes.shape}"
        )
    if ids.dtype.kind not in "iu" and n:
        raise BadRows(f"ids of type {ids.dtype}: they must be whole numbers")
    strange = set(np.asarray(rows.frames).tolist()) - {*allowed}
    if strange:
        raise BadRows(f"rows of another frame: {sorted(strange)}")
    bad = ~np.isfinite(boxes).all(axis=1)
    if np.count_nonzero(bad):
        raise BadRows(f"boxes that are not finite, of ids {ids[bad].tolist()}")
    if np.count_nonzero(ids < 0):
        raise BadRows(f"ids below 0: {ids[ids < 0].tolist()}")
    listed = list(zip(np.asarray(rows.frames).tolist(), ids.tolist(), strict=True))
    if len(set(listed)) < n:
        twice = sorted(each for each, count in Counter(listed).items() if count > 1)
        raise BadRows(f"ids that stand twice in a frame: {[name for _, name in twice]}")


def _plain(number: int | float) -> int | float:
    """A number of Python, which JSON gives back to the last digit."""
    return int(number) if isinstance(number, int | np.integer) else float(number)

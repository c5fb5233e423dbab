"""One trial: a tracker over one drive, its output checked, then scored; what fails is said.

A worker does the trials of one seed under one condition together: they share what they are given.
"""

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from time import thread_time
from warnings import catch_warnings, simplefilter

import numpy as np

from mot_sim.experiments.sweep.conditions import Conditions
from mot_sim.experiments.sweep.drives import Recordings, TrialSequence, drive_of
from mot_sim.experiments.sweep.store import SweepFolder, TrialOutcome
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.files.fingerprint import code_digest
from mot_sim.foreign.answers import BadRows
from mot_sim.foreign.isolation import close_tracker, steps_of
from mot_sim.metrics import evaluate_sequence
from tracker import Frame, Tracks
from tracker.errors import BadConfig, MotionWarning, WorkersLost

MAX_ERROR_LETTERS = 300  # that are kept of what a tracker says


@contextmanager
def wrong_motion_allowed() -> Iterator[None]:
    """No MotionWarning inside: wrong motion may be what is studied."""
    with catch_warnings():
        simplefilter("ignore", MotionWarning)
        yield


def run_trial(
    contender: TrackerSpec, drive: TrialSequence, rules: str = "trackeval", spatial: bool = False
) -> TrialOutcome:
    """Track and score; whatever a tracker raises, or gives that is no output, is the error."""
    start, detections = thread_time(), 0
    came: list[int] = []
    parts: list[Tracks] = []
    at, tracker, said = "before the first frame", None, ""

    def asked(frame: Frame) -> None:
        nonlocal at, detections
        at = f"frame {frame.index}"
        detections += len(frame.found)
        came.append(frame.index)

    try:
        tracker = contender.start(drive.sequence.camera, drive.frame_rate)
        is_late = callable(getattr(tracker, "finish", None))
        with wrong_motion_allowed():
            for rows in steps_of(tracker, drive.sequence, asked):
                require_rows(rows, came if is_late else came[-1:])
                parts.append(rows)
        if is_late:
            at = "after the last frame"
            parts.append(tracker.finish())  # type: ignore[attr-defined]
            require_rows(parts[-1], came)
        output = Tracks.concatenate(parts) if parts else Tracks.empty()
        seconds = thread_time() - start + getattr(tracker, "cpu_seconds", 0.0)
        said = close_tracker(tracker)
        at = "in the end"
        require_rows(output, came)
        at = "scoring"
        scores = scores_of(output, drive, rules, spatial)
    except (Exception, SystemExit) as error:  # noqa: BLE001
        kind = "" if isinstance(error, BadRows) else f"{type(error).__name__}: "
        words = " ".join(f"{at}: {kind}{error}".split())[:MAX_ERROR_LETTERS]
        said = getattr(error, "said", "") or said or close_tracker(tracker)
        return TrialOutcome({}, words, len(came), detections, thread_time() - start, said)
    finally:
        close_tracker(tracker)  # when we are interrupted, too
    return TrialOutcome(scores, None, len(came), detections, seconds, said)


def scores_of(
    output: Tracks, drive: TrialSequence, rules: str, spatial: bool = False
) -> dict[str, int | float]:
    """The scores of an output by name, those that are NaN left out; spatial: of cuboids, too."""
    scores = evaluate_sequence(drive.truth, output, drive.frame_count, rules).numbers()
    if spatial:
        scores |= drive.spatial_scores(output).numbers()
    return {name: _plain(value) for name, value in scores.items() if not np.isnan(value)}


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


@dataclass(frozen=True)
class Job:
    """Trials that share conditions and seed, and so what the trackers are given."""

    folder: Path
    """The sweep's folder, under the same path on every worker."""
    code: str
    """Hash of the source code of the process that asks; a worker with other code refuses the
    job."""
    rules: str
    """Rules of scoring, one of `mot_sim.metrics.RULES`."""
    spatial: bool
    """Whether cuboids are scored, too."""
    recordings: Recordings
    """Where traffic and truth are kept."""
    conditions: Conditions
    """What the trials are run under."""
    seed: int
    """The seed of the run."""
    trials: tuple[tuple[str, TrackerSpec], ...] = ()
    """Keys and trackers; empty: only the truth is recorded."""

    def about(self, contender: TrackerSpec) -> dict[str, str | int]:
        """What a person wants to know who opens the file of one of the trials."""
        return {
            "tracker": contender.name,
            "scene": self.conditions.scene,
            "seed": self.seed,
        }


@dataclass(frozen=True)
class JobDone:
    """What is told of a job that is done; its trials are in the folder."""

    trials: int
    """Number of its trials."""
    said: tuple[tuple[str, str], ...] = ()
    """What its trackers printed: tracker and seed, and the end of it."""


def run_job(job: Job) -> JobDone:
    """Do a job; each of its trials is written as soon as it is finished.

    What goes wrong before a tracker is asked is the error of all the trials. Raises BadConfig
    where the code here is not the code that asked.
    """
    require_same_code(job)
    folder = SweepFolder(job.folder)
    drive = drive_for(job)
    said: list[tuple[str, str]] = []
    for key, contender in job.trials:
        if isinstance(drive, TrialSequence):
            outcome = run_trial(contender, drive, job.rules, job.spatial)
        else:
            outcome = TrialOutcome({}, drive)
        folder.write(key, outcome, job.about(contender))
        if outcome.output:
            said.append((f"{contender.name}, seed {job.seed}", outcome.output))
    return JobDone(len(job.trials), tuple(said))


def require_same_code(job: Job) -> None:
    """Raise BadConfig where the code here is not the code that asked."""
    if job.code != code_digest():
        raise BadConfig(
            f"a worker has other code or libraries ({code_digest()[:8]}, asked {job.code[:8]}): "
            "install the same mot-sim, numpy, scipy and OpenCV on all machines"
        )


def without_lost(job: Job) -> tuple[JobDone, list[Job]]:
    """What is told of a job whose process died twice, and a job of the trials that are left.

    The trial that it died in is the first without a result, and has failed. Raises WorkersLost
    where no tracker was asked yet.
    """
    if not job.trials:
        raise WorkersLost("processes that record traffic and truth die: is there enough memory?")
    folder = SweepFolder(job.folder)
    finished = [folder.read(key) is not None for key, _ in job.trials]
    place = finished.index(False) if False in finished else len(finished) - 1
    key, contender = job.trials[place]
    died = TrialOutcome({}, "the process of the trial died, and died again")
    folder.write(key, died, job.about(contender))
    rest = job.trials[place + 1 :]
    return JobDone(place + 1), [replace(job, trials=rest)] if rest else []


def drive_for(job: Job) -> TrialSequence | str:
    """What the trackers are given; or what went wrong with it."""
    try:
        if not job.trials:
            job.recordings.record_truth(job.conditions, job.seed)
            return ""
        recorded = job.recordings.truth(job.conditions, job.seed)
        return drive_of(job.conditions, recorded, job.seed)
    except OSError:
        raise  # a disk that is full or gone is no result
    except Exception as error:  # noqa: BLE001
        return " ".join(f"no drive: {type(error).__name__}: {error}".split())[:MAX_ERROR_LETTERS]

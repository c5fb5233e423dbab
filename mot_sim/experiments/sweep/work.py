"""What a worker does: it makes truths, and runs the trials of one seed under one condition."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import cv2
from threadpoolctl import threadpool_limits

from mot_sim.experiments.sweep.conditions import Conditions
from mot_sim.experiments.sweep.drives import Recordings, TrialSequence, drive_of
from mot_sim.experiments.sweep.store import SweepFolder
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.experiments.sweep.trial import MOST_WORDS, TrialOutcome, run_trial
from mot_sim.files.fingerprint import code_digest
from tracker.errors import BadConfig


@dataclass(frozen=True)
class Job:
    """Trials that share conditions and seed, and so what the trackers are given.

    code: of the process that asks. trials: their keys and trackers; without any the truth alone
    is made.
    """

    folder: Path
    code: str
    rules: str
    conditions: Conditions
    seed: int
    trials: tuple[tuple[str, TrackerSpec], ...] = ()


def run_job(job: Job) -> int:
    """Do a job and give the number of its trials; each is written as soon as it is finished.

    What goes wrong before a tracker is asked is the error of all the trials. Raises BadConfig
    where the code here is not the code that asked.
    """
    if job.code != code_digest():
        raise BadConfig(
            f"a worker has other code or libraries ({code_digest()[:8]}, asked {job.code[:8]}): "
            "install the same mot-sim, numpy, scipy and OpenCV on all machines"
        )
    folder = SweepFolder(job.folder)
    drive = _drive(job)
    for key, contender in job.trials:
        about = {"tracker": contender.name, "scene": job.conditions.scene, "seed": job.seed}
        if isinstance(drive, TrialSequence):
            outcome = run_trial(contender, drive, job.rules)
        else:
            outcome = TrialOutcome({}, drive)
        folder.write(key, outcome, about)
    return len(job.trials)


def _drive(job: Job) -> TrialSequence | str:
    """What the trackers are given; or what went wrong with it."""
    try:
        recorded = Recordings(job.folder).truth(job.conditions, job.seed)
        if not job.trials:
            return ""
        return drive_of(job.conditions, recorded, job.seed)
    except OSError:
        raise  # a disk that is full or gone is no result
    except Exception as error:  # noqa: BLE001
        return " ".join(f"no drive: {type(error).__name__}: {error}".split())[:MOST_WORDS]


def run_alone(job: Job) -> int:
    """`run_job` in a worker process, whose libraries have one thread from now on."""
    threadpool_limits(1)
    cv2.setNumThreads(1)
    return run_job(job)


@contextmanager
def one_thread() -> Iterator[None]:
    """While it lasts, BLAS, numpy and OpenCV of this process have one thread."""
    before = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        with threadpool_limits(1):
            yield
    finally:
        cv2.setNumThreads(before)

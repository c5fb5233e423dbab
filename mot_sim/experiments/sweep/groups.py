"""Jobs that one process does together: a tracker follows their drives side by side.

Almost all that a frame costs is the calls of many small steps, which drives that are followed
together share; the rows are those that each drive gives alone, bit for bit.
"""

import logging
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from time import thread_time

from mot_sim.experiments.sweep.drives import TrialSequence
from mot_sim.experiments.sweep.store import SweepFolder, TrialOutcome
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.experiments.sweep.trial import (
    Job,
    JobDone,
    drive_for,
    require_rows,
    require_same_code,
    run_job,
    scores_of,
    without_lost,
    wrong_motion_allowed,
)
from mot_sim.files.fingerprint import digest
from mot_sim.simulation.rig import Rig
from tracker import Camera, Frame, Tracker, Tracks
from tracker.batch import (
    PreparedFrames,
    decisive_parts,
    follows_together,
    prepare_frames,
    track_drives,
)

log = logging.getLogger(__name__)
MAX_DRIVES = 25  # of a group; more are hardly faster
MAX_FRAMES = 5000  # that are held at once
MIN_GROUPS = 4  # for each process, so that none waits for long, and progress is told


@dataclass(frozen=True)
class JobGroup:
    """Jobs that one process does together; a single one is done as it is."""

    jobs: tuple[Job, ...]
    """At least one; none of several jobs records truth."""


@dataclass(frozen=True, eq=False)
class Alike:
    """A trial that may be done together with others of the same tracker and camera."""

    job: Job
    """The job that it is of."""
    key: str
    """Its key."""
    contender: TrackerSpec
    """Its tracker."""
    drive: TrialSequence
    """What the tracker is given, and scored against."""
    frames: list[Frame]
    """The frames of that."""


# What trackers made of frames, by what decides that, and the identity of the list of frames.
Prepared = dict[tuple[str, int], PreparedFrames | None]


def grouped(jobs: Sequence[Job], processes: int) -> list[JobGroup]:
    """Groups of neighbours whose trackers can follow several drives at once, and all other jobs.

    processes: that share the work.
    """
    can: dict[str, bool] = {}
    together: list[Job] = []
    alone: list[Job] = []
    for job in jobs:
        for contender in (contender for _, contender in job.trials):
            if _settings(contender) not in can:
                can[_settings(contender)] = _can_share(contender)
        shares = [can[_settings(contender)] and not job.spatial for _, contender in job.trials]
        for part, chosen in ((together, True), (alone, False)):
            trials = tuple(
                trial for trial, share in zip(job.trials, shares, strict=True) if share == chosen
            )
            if trials:
                part.append(replace(job, trials=trials))
    most = max(1, min(MAX_DRIVES, -(-len(together) // (MIN_GROUPS * processes))))
    parts = [tuple(together[at : at + most]) for at in range(0, len(together), most)]
    return [JobGroup(part) for part in [*parts, *((job,) for job in alone)]]


def run_group(group: JobGroup) -> JobDone:
    """Do the jobs of a group; each trial is written as soon as it is finished.

    Raises as `run_job`.
    """
    done = set() if len(group.jobs) == 1 else _run_together(group)
    said: list[tuple[str, str]] = []
    for job in group.jobs:
        left = tuple(trial for trial in job.trials if trial[0] not in done)
        if left:
            said += run_job(replace(job, trials=left)).said
    return JobDone(sum(len(job.trials) for job in group.jobs), tuple(said))


def group_without_lost(group: JobGroup) -> tuple[JobDone, list[JobGroup]]:
    """What is told of a group whose process died twice, and groups of the trials that are left.

    Its jobs are done one by one, and of a single job the trial that it died in has failed; see
    `without_lost`.
    """
    if len(group.jobs) == 1:
        lost, rest = without_lost(group.jobs[0])
        return lost, [JobGroup((job,)) for job in rest]
    folder, left, count = SweepFolder(group.jobs[0].folder), list[JobGroup](), 0
    for job in group.jobs:
        trials = tuple(trial for trial in job.trials if folder.read(trial[0]) is None)
        count += len(job.trials) - len(trials)
        if trials:
            left.append(JobGroup((replace(job, trials=trials),)))
    return JobDone(count), left


def _run_together(group: JobGroup) -> set[str]:
    """The keys of the trials that were done side by side; they are written."""
    alike: dict[tuple[object, ...], list[Alike]] = {}
    done: set[str] = set()
    held = 0
    for job in group.jobs:
        require_same_code(job)
        drive = drive_for(job)
        if not isinstance(drive, TrialSequence):
            continue  # all trials of the job have failed: it says so
        frames = list(drive.sequence)
        if any(_has_cues(frame) for frame in frames):
            continue
        for key, contender in job.trials:
            same = _settings(contender), drive.frame_rate, *_numbers(drive.sequence.camera)
            alike.setdefault(same, []).append(Alike(job, key, contender, drive, frames))
        held += len(frames)
        if held > MAX_FRAMES:
            done |= _track_all(alike.values())
            alike, held = {}, 0
    return done | _track_all(alike.values())


def _track_all(alike: Iterable[list[Alike]]) -> set[str]:
    """The keys of those trials that are done; the others are to be done alone."""
    prepared: Prepared = {}
    return set[str]().union(*(_track_together(trials, prepared) for trials in alike))


def _track_together(trials: list[Alike], known: Prepared) -> set[str]:
    """The same of the trials of one tracker. known: what trackers have made of frames so far.

    Whatever goes wrong for one of them goes wrong again where it is done alone, and is told there.
    """
    first = trials[0]
    start = thread_time()
    try:
        tracker = first.contender.build(first.drive.sequence.camera, first.drive.frame_rate)
        assert isinstance(tracker, Tracker)
        with wrong_motion_allowed():
            how = digest(decisive_parts(tracker))
            for trial in trials:
                if (how, id(trial.frames)) not in known:
                    known[how, id(trial.frames)] = _prepared(tracker, trial)
            prepared = [known[how, id(trial.frames)] for trial in trials]
            ready = [at for at, frames in enumerate(prepared) if frames is not None]
            if len(ready) < 2:
                return set()
            trials = [trials[at] for at in ready]
            numbers = [[frame.index for frame in trial.frames] for trial in trials]
            frames = [each for each in prepared if each is not None]
            outputs = track_drives(tracker, frames, numbers)
    except Exception as error:  # noqa: BLE001
        log.info("%s: one drive after the other: %s", first.contender.name, error)
        return set()
    each = (thread_time() - start) / max(sum(map(len, numbers)), 1)
    return {
        trial.key
        for trial, output in zip(trials, outputs, strict=True)
        if _is_written(trial, output, each * len(trial.frames))
    }


def _prepared(tracker: Tracker, trial: Alike) -> PreparedFrames | None:
    """The frames of a trial; None where the tracker does not take them."""
    try:
        return prepare_frames(tracker, trial.frames, trial.drive.sequence.name)
    except Exception:  # noqa: BLE001
        return None


def _is_written(trial: Alike, output: Tracks, seconds: float) -> bool:
    """Score and write a trial; False for what is no output."""
    job, frames = trial.job, trial.frames
    try:
        require_rows(output, [frame.index for frame in frames])
        scores = scores_of(output, trial.drive, job.rules)
    except Exception:  # noqa: BLE001
        return False
    detections = sum(len(frame.found) for frame in frames)
    outcome = TrialOutcome(scores, None, len(frames), detections, seconds)
    SweepFolder(job.folder).write(trial.key, outcome, job.about(trial.contender))
    return True


def _can_share(contender: TrackerSpec) -> bool:
    """Whether a tracker may follow several drives at once."""
    if not contender.is_ours or contender.isolation.covers(is_ours=True):
        return False
    return follows_together(contender.build(Rig.kitti().camera))


def _settings(contender: TrackerSpec) -> str:
    """What decides what a tracker does, for a comparison."""
    return repr((contender.made_by, sorted(contender.settings.items()), contender.isolation))


def _has_cues(frame: Frame) -> bool:
    """Whether anything but boxes and scores was measured."""
    found = frame.found
    names = (name for name in found.__match_args__ if name not in ("boxes", "scores", "kinds"))
    return any(getattr(found, name) is not None for name in names)


def _numbers(camera: Camera) -> Iterable[object]:
    """All that a camera is."""
    return camera.K.tobytes(), camera.image_size, camera.T_cam_road.tobytes()


__all__ = ["JobGroup", "group_without_lost", "grouped", "run_group"]

"""Jobs done together: the trials, numbers and errors of one job after the other."""

from pathlib import Path
from unittest.mock import patch

import pytest

from mot_sim.experiments.sweep import groups, running
from mot_sim.experiments.sweep.design import Design
from mot_sim.experiments.sweep.drives import Recordings
from mot_sim.experiments.sweep.groups import JobGroup, group_without_lost, grouped, run_group
from mot_sim.experiments.sweep.running import SweepPlan, sweep
from mot_sim.experiments.sweep.store import SweepFolder
from mot_sim.experiments.sweep.trial import Job
from tests.mot_sim.experiments.small import BARE, numbers, small_design

ODD = "tests.mot_sim.experiments.odd"
MIXED = ("default", "paper", f"odd={ODD}:Raises", "cues=default:costs=shape_pose=1")


def jobs_of(design: Design, folder: Path) -> list[Job]:
    SweepFolder.open(folder, design.description())
    return SweepPlan(design, folder).jobs({}, Recordings(folder))


def names(group: JobGroup) -> list[list[str]]:
    return [[contender.name for _, contender in job.trials] for job in group.jobs]


def test_neighbours_are_done_together_as_far_as_their_trackers_can(tmp_path: Path) -> None:
    jobs = jobs_of(small_design(trackers=MIXED), tmp_path)
    assert len(jobs) == 6
    found = grouped(jobs, 1)
    assert [names(group) for group in found] == [
        *([[["default", "paper"]] * 2] * 3),
        *([[["odd", "cues"]]] * 6),
    ]
    assert [names(group) for group in grouped(jobs, 3)][:6] == [[["default", "paper"]]] * 6
    whole = [trial for group in found for job in group.jobs for trial in job.trials]
    assert sorted(key for key, _ in whole) == sorted(key for job in jobs for key, _ in job.trials)


def test_where_cuboids_are_scored_each_job_is_done_alone(tmp_path: Path) -> None:
    jobs = jobs_of(small_design(trackers=("default",), spatial=True), tmp_path)
    assert [group.jobs for group in grouped(jobs, 1)] == [(job,) for job in jobs]


@pytest.mark.parametrize(
    "changes",
    [
        {"trackers": MIXED},
        {"axes": {"tracker.lifecycle.max_gap": (0.0, 1.0), "timing.drops": (0.0, 0.4)}},
        {
            "axes": {"rig.pitch_error_deg": (0.0, 0.5)},
            "fixed": {**BARE, "odometry.drift": 0.05},
            "seeds": 8,
        },
    ],
    ids=["trackers", "lost frames", "cameras"],
)
def test_together_gives_the_table_of_one_after_the_other(changes: dict[str, object]) -> None:
    design = small_design(**changes)
    with patch.object(groups, "track_drives", wraps=groups.track_drives) as used:
        together = numbers(sweep(design))
    assert used.call_count > 0
    with patch.object(running, "grouped", lambda jobs, _: [JobGroup((job,)) for job in jobs]):
        alone = numbers(sweep(design))
    assert together.equals(alone)


def test_what_goes_wrong_together_is_done_alone() -> None:
    design = small_design()
    with patch.object(groups, "track_drives", side_effect=ZeroDivisionError("no drive")) as used:
        table = sweep(design)
    assert used.call_count > 0
    assert numbers(table).equals(numbers(sweep(design)))


def test_jobs_that_share_a_process_that_died_are_left_one_by_one(tmp_path: Path) -> None:
    jobs = jobs_of(small_design(), tmp_path)
    group = JobGroup(tuple(jobs[:3]))
    done, left = group_without_lost(group)
    assert (done.trials, left) == (0, [JobGroup((job,)) for job in jobs[:3]])
    assert run_group(JobGroup(tuple(jobs[:2]))).trials == 4
    done, left = group_without_lost(group)
    assert (done.trials, left) == (4, [JobGroup((jobs[2],))])
    done, left = group_without_lost(left[0])  # now the trial that it died in has failed
    assert (done.trials, len(left)) == (1, 1)
    assert SweepFolder(tmp_path).read(jobs[2].trials[0][0]).error is not None

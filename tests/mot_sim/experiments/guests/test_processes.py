"""Commands of guests: statuses, time limits, what they say."""

import os
import sys
import time
from pathlib import Path

import pytest

from mot_sim.experiments.guests import ExternalTrackerFailed
from mot_sim.foreign.processes import guest_environ, one_core, run_process


def python(code: str) -> list[str]:
    """A command that runs the code."""
    return [sys.executable, "-c", code]


def test_what_a_command_says_comes_back() -> None:
    said = run_process("mine", python("import sys; print('hi', file=sys.stderr); print(1)"), 30.0)
    assert said == "hi"


def test_a_failing_command_is_named_with_its_status_and_stderr() -> None:
    with pytest.raises(ExternalTrackerFailed) as caught:
        run_process("mine", python("import sys; print('oh', file=sys.stderr); sys.exit(3)"), 30.0)
    assert str(caught.value).startswith("guest mine: exit status 3 from python")
    assert (caught.value.guest, caught.value.stderr) == ("mine", "oh")


def test_a_command_that_was_killed_says_by_what() -> None:
    with pytest.raises(ExternalTrackerFailed, match="killed by SIGABRT, exit status -6"):
        run_process("mine", python("import os; os.abort()"), 30.0)


def test_a_command_that_is_not_there_is_told() -> None:
    with pytest.raises(
        ExternalTrackerFailed, match="'no-such-program' cannot be started: No such file"
    ):
        run_process("mine", ["no-such-program"], 30.0)


def test_only_the_end_of_a_long_story_is_kept() -> None:
    code = "import sys; [print('line', n, file=sys.stderr) for n in range(5_000)]"
    said = run_process("mine", python(code), 30.0).splitlines()
    assert (len(said), said[0], said[-1]) == (20, "line 4980", "line 4999")


def test_too_long_ends_the_command_and_what_it_started(programs: Path, tmp_path: Path) -> None:
    note = tmp_path / "pid"
    with pytest.raises(ExternalTrackerFailed, match=r"not done after 1\.5 s and killed") as caught:
        run_process("slow", [sys.executable, str(programs / "hangs.py"), str(note)], 1.5)
    assert caught.value.stderr == "thinking"
    child = int(note.read_text())
    for _ in range(100):
        if not is_alive(child):
            return
        time.sleep(0.05)
    pytest.fail(f"process {child} outlives its guest")


def is_alive(pid: int) -> bool:
    """Whether a process runs; a dead one that nobody has asked after does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_guests_do_not_inherit_our_python_and_have_one_thread() -> None:
    given = guest_environ({"PYTHONPATH": "/ours", "HOME": "/home", "OMP_NUM_THREADS": "8"})
    assert "PYTHONPATH" not in given
    assert given["HOME"] == "/home"
    assert given["OMP_NUM_THREADS"] == given["OPENBLAS_NUM_THREADS"] == "1"


@pytest.mark.skipif(not hasattr(os, "sched_getaffinity"), reason="no core can be chosen here")
def test_one_core_is_one_core_and_ends() -> None:
    before = os.sched_getaffinity(0)
    with one_core():
        assert len(os.sched_getaffinity(0)) == 1
    assert os.sched_getaffinity(0) == before

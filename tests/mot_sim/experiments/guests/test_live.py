"""Guests that are stepped frame by frame."""

import gc
import os
import sys
import time
from pathlib import Path

import pytest

from mot_sim.datasets import RecordedSequence
from mot_sim.experiments.guests import (
    GUESTS,
    ExternalOnlineTracker,
    ExternalTracker,
    ExternalTrackerFailed,
)
from tests.mot_sim.experiments.guests.conftest import truth_of
from tests.mot_sim.experiments.guests.test_processes import is_alive
from tracker.errors import BadConfig, BadTracks, UnknownName
from tracker.types import Tracks

FOLDERS = ("x", "{detections}", "{results}")
NUMBERS = """
import json, sys
rate = float(sys.stdin.readline())
for line in sys.stdin:
    rows = [[number, *row] for number, row in enumerate(json.loads(line))]
    print(json.dumps(rows), flush=True)
"""


def live(code: str, timeout: float = 30.0) -> ExternalOnlineTracker:
    """A live guest that runs the code."""
    return ExternalOnlineTracker(
        ExternalTracker("mine", FOLDERS, timeout=timeout, live=("{python}", "-c", code))
    )


def test_a_live_guest_is_stepped_like_a_tracker(drives: list[RecordedSequence]) -> None:
    guest = live(NUMBERS)
    tracks = Tracks.concatenate([guest.step(frame) for frame in drives[0]])
    truth = truth_of(drives[0])
    assert tracks.frames.tolist() == truth.frames.tolist()
    assert tracks.ids.tolist() == (truth.ids - 7).tolist()
    assert tracks.boxes.tolist() == truth.boxes.tolist()
    guest.close()


@pytest.mark.parametrize(
    ("code", "told"),
    [
        ("import sys; sys.exit('no weights')", "ended before its drive did; it said: no weights"),
        ("input(); input(); print('hello')", "frame 0: no rows id x1 y1 x2 y2 score: 'hello"),
        ("input(); input(); print('[[1, 2, 3]]')", "no rows id x1 y1 x2 y2 score"),
        ("input(); input(); print('[[0, 1, 2, 3, NaN, 1]]')", "no rows id x1 y1 x2 y2 score"),
        ("input(); input(); print('[[-1, 1, 2, 3, 4, 1]]')", "no rows id x1 y1 x2 y2 score"),
        ("import time; time.sleep(60)", "no answer for 0.5 s"),
    ],
)
def test_what_is_no_answer_is_told(code: str, told: str, drives: list[RecordedSequence]) -> None:
    guest = live(code, timeout=0.5 if "sleep" in code else 30.0)
    with pytest.raises(ExternalTrackerFailed) as caught:
        guest.step(next(iter(drives[0])))
    assert told in str(caught.value)


def test_an_id_twice_in_a_frame_is_told(drives: list[RecordedSequence]) -> None:
    guest = live("input(); input(); print('[[1, 1, 2, 3, 4, 1], [1, 5, 6, 7, 8, 1]]')")
    with pytest.raises(BadTracks, match="guest mine: id 1 stands twice in frame 0"):
        guest.step(next(iter(drives[0])))
    guest.close()


def test_its_process_ends_with_it(drives: list[RecordedSequence], tmp_path: Path) -> None:
    note = tmp_path / "pid"
    guest = live(f"import os; open({str(note)!r}, 'w').write(str(os.getpid()))\n{NUMBERS}")
    guest.step(next(iter(drives[0])))
    pid = int(note.read_text())
    assert pid != os.getpid()
    assert is_alive(pid)
    del guest
    gc.collect()
    for _ in range(100):
        if not is_alive(pid):
            return
        time.sleep(0.05)
    pytest.fail(f"process {pid} outlives its guest")


def test_a_guest_that_knows_only_folders_is_refused() -> None:
    with pytest.raises(BadConfig, match="guest mine knows only folders"):
        ExternalOnlineTracker(ExternalTracker("mine", FOLDERS))


def test_an_unknown_name_is_answered_with_the_nearest() -> None:
    with pytest.raises(UnknownName, match="Did you mean 'oc-sort'"):
        ExternalOnlineTracker("ocsort")


def test_every_guest_of_the_package_can_be_stepped() -> None:
    assert all(guest.live and sys.executable not in guest.live for guest in GUESTS.values())

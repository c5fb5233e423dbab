"""Tracks: one id names one object a frame."""

import numpy as np
import pytest

from tracker.errors import BadTracks
from tracker.types import Tracks


def tracks(frames: list[int], ids: list[int]) -> Tracks:
    return Tracks(np.array(frames), np.array(ids), np.zeros((len(frames), 4)))


def test_an_id_twice_in_a_frame_is_refused_with_id_frame_and_place() -> None:
    with pytest.raises(BadTracks, match=r"results.txt: id 7 stands twice in frame 3"):
        tracks([3, 2, 3, 3], [7, 7, 1, 7]).require_unique_ids("results.txt")


def test_the_same_id_in_different_frames_is_what_a_track_is() -> None:
    tracks([0, 1, 2], [7, 7, 7]).require_unique_ids()


def test_negative_ids_name_nobody_and_may_repeat() -> None:
    tracks([0, 0, 0], [-1, -1, 3]).require_unique_ids()


def test_no_rows_are_unique() -> None:
    Tracks.empty().require_unique_ids()
    assert len(Tracks.empty()) == 0

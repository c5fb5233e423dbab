"""Recorded traffic: equal to the live one, bit for bit, and safe in its file."""

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from mot_sim.simulation.traffic import (
    RecordedTraffic,
    Replay,
    Route,
    Script,
    Scripted,
    TrafficState,
    record_traffic,
)
from tracker.errors import BadConfig, BadFile, BadOutput

RNG = np.random.default_rng(0)
EGO = Script(Route([(0.0, 0.0), (90.0, 0.0)]), [(0.0, 8.0)])
# One stays for 0.7 s, one comes after 0.5 s, one is always there.
CARS = (
    Script(Route([(5.0, 3.0), (9.0, 3.0)]), [(0.0, 5.5)]),
    Script(Route([(5.0, 9.0), (90.0, 9.0)]), [(0.0, 5.0)], begin=0.5, size=(3.7, 1.5, 1.6)),
    Script(Route([(50.0, -3.0), (5.0, -3.0)]), [(0.0, 7.0)]),
)


def recording() -> RecordedTraffic:
    return record_traffic(Scripted(CARS, EGO), RNG, 2.0)


def assert_same(one: TrafficState, other: TrafficState) -> None:
    for column in fields(TrafficState):
        a, b = getattr(one, column.name), getattr(other, column.name)
        assert (a is None) == (b is None), column.name
        assert a is None or np.asarray(a).tobytes() == np.asarray(b).tobytes(), column.name


def test_a_replay_equals_the_live_traffic_bit_for_bit() -> None:
    live, replay = Scripted(CARS, EGO), Replay(recording())
    assert_same(live.reset(RNG), replay.reset(RNG))
    for _ in range(20):
        assert_same(live.step(), replay.step())


def test_a_replay_begins_again_after_reset_and_ends_with_the_recording() -> None:
    replay = Replay(record_traffic(Scripted(CARS, EGO), RNG, 0.1))
    replay.reset(RNG)
    replay.step()
    with pytest.raises(BadConfig, match="ends after 2 states"):
        replay.step()
    assert replay.reset(RNG).time == 0.0


def test_columns_are_cars_and_absent_ones_are_nan() -> None:
    recorded = recording()
    assert recorded.ids.tolist() == [0, 1, 2]
    assert len(recorded) == 21
    assert recorded.present.sum(axis=0).tolist() == [8, 16, 21]
    assert (np.isnan(recorded.x) == ~recorded.present).all()


def test_a_file_gives_the_same_recording_and_the_same_bytes(tmp_path: Path) -> None:
    recording().save(tmp_path / "a.npz")
    recording().save(tmp_path / "deep" / "b.npz")
    again = RecordedTraffic.load(tmp_path / "a.npz")
    assert again.checksum == recording().checksum
    assert_same(again.state(6), recording().state(6))
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "deep" / "b.npz").read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.npz", "deep"]


def test_traffic_without_cars_is_recorded_too(tmp_path: Path) -> None:
    record_traffic(Scripted((), EGO), RNG, 1.0).save(tmp_path / "empty.npz")
    state = Replay(RecordedTraffic.load(tmp_path / "empty.npz")).reset(RNG)
    assert len(state) == 0
    assert state.size.shape == (0, 3)


def test_height_crashes_and_tilt_are_kept(tmp_path: Path) -> None:
    state = Scripted(CARS, EGO).reset(RNG)
    tilted = replace(
        state,
        z=np.array([0.1, -0.2]),
        crashed=np.array([True, False]),
        tilt=np.array([0.01, -0.02]),
    )
    recorded = RecordedTraffic.of([tilted, tilted])
    assert_same(recorded.state(0), tilted)
    recorded.save(tmp_path / "traffic.npz")
    assert_same(RecordedTraffic.load(tmp_path / "traffic.npz").until(1).state(0), tilted)


@pytest.mark.parametrize("bytes_kept", [0, 10, 400, -30], ids=str)
def test_a_cut_file_is_named(tmp_path: Path, bytes_kept: int) -> None:
    path = tmp_path / "cut.npz"
    recording().save(path)
    path.write_bytes(path.read_bytes()[:bytes_kept])
    with pytest.raises(BadFile, match=r"cut\.npz"):
        RecordedTraffic.load(path)


def test_no_flipped_bit_goes_unseen(tmp_path: Path) -> None:
    path = tmp_path / "bits.npz"
    recording().save(path)
    whole = path.read_bytes()
    for place in range(40, len(whole) - 400, 97):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 4]) + whole[place + 1 :])
        try:
            again = RecordedTraffic.load(path)
        except BadFile:
            continue
        assert again.checksum == recording().checksum  # a bit of zip's own that means nothing


def test_changed_arrays_and_older_files_are_told_from_good_ones(tmp_path: Path) -> None:
    path = tmp_path / "traffic.npz"
    recording().save(path)
    with np.load(path) as archive:
        arrays = dict(archive)
    np.savez(path, **{**arrays, "x": arrays["x"] + 1e-9})
    with pytest.raises(BadFile, match=r"traffic\.npz: its arrays do not have the SHA-256"):
        RecordedTraffic.load(path)
    np.savez(path, **{**arrays, "head": np.array('{"version": 0, "sha256": ""}')})
    with pytest.raises(BadFile, match="version 0, this is 1: record again"):
        RecordedTraffic.load(path)
    np.savez(path, head=arrays["head"], x=arrays["x"])
    with pytest.raises(BadFile, match="lacks"):
        RecordedTraffic.load(path)
    np.savez(path, x=arrays["x"])
    with pytest.raises(BadFile, match="its head is None"):
        RecordedTraffic.load(path)
    np.save(path.with_suffix(".npy"), arrays["x"])
    with pytest.raises(BadFile, match=r"traffic\.npy"):
        RecordedTraffic.load(path.with_suffix(".npy"))
    with pytest.raises(BadFile, match="no such file"):
        RecordedTraffic.load(tmp_path / "none.npz")


def test_a_place_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(BadOutput, match="cannot be written"):
        recording().save(tmp_path / "file" / "traffic.npz")


def test_bad_recordings_are_told() -> None:
    with pytest.raises(BadConfig, match="record -1 s"):
        record_traffic(Scripted(CARS, EGO), RNG, -1.0)
    with pytest.raises(BadConfig, match="no states"):
        RecordedTraffic.of([])
    state = Scripted(CARS, EGO).reset(RNG)
    with pytest.raises(BadConfig, match=r"ids \[2, 0\] do not increase"):
        RecordedTraffic.of([replace(state, ids=state.ids[::-1].copy())])

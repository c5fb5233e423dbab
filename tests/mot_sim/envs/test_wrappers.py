"""Tracks in the observation, their scores in the info, and CLEAR counted frame by frame."""

import pickle

import gymnasium as gym
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mot_sim  # noqa: F401  (registers the ids)
from mot_sim.envs.wrappers import (
    RunningClear,
    RunningCounts,
    Scored,
    TrackObservation,
    counted_labels,
)
from mot_sim.metrics import evaluate_sequence
from mot_sim.simulation.episode import record
from mot_sim.simulation.registry import find_scene
from tracker import Tracker
from tracker.errors import BadConfig, BadTracks, UnknownName
from tracker.types import Tracks

FRAMES = 18
CLEAR_FRAMES = 8


def make(**options) -> gym.Env:
    return gym.make("mot_sim/Crossing-v0", frames=FRAMES, image=False, **options)


def test_tracks_are_the_trackers_and_scores_are_evaluates() -> None:
    env = Scored(TrackObservation(make(), tracker="paper"))
    observation, told = env.reset(options={"episode_seed": 6})
    assert told["final_scores"] is None
    assert observation in env.observation_space
    rows, truncated = [env.env.tracks], False
    while not truncated:
        observation, _, _, truncated, told = env.step(0)
        assert observation in env.observation_space
        rows.append(env.env.tracks)
    episode = record(find_scene("crossing", frames=FRAMES), seed=6)
    tracker = Tracker.paper(episode.camera)
    expected = Tracks.concatenate([tracker.step(frame) for frame in episode])
    output = Tracks.concatenate(rows)
    np.testing.assert_array_equal(output.ids, expected.ids)
    np.testing.assert_array_equal(output.boxes, expected.boxes)
    whole = evaluate_sequence(episode.truth, expected, FRAMES)
    assert told["final_scores"].numbers() == whole.numbers()
    for name, number in told["scores"].items():
        assert number == pytest.approx(whole[name], abs=1e-12), name


def test_a_reset_forgets_tracks_and_counts() -> None:
    env = Scored(TrackObservation(make()))
    first = env.reset(options={"episode_seed": 6})[1]["scores"]
    env.step(0)
    assert env.reset(options={"episode_seed": 6})[1]["scores"] == first


def test_the_wrappers_travel() -> None:
    env = Scored(TrackObservation(make(), max_tracks=5))
    env.reset(seed=1)
    copy = pickle.loads(pickle.dumps(env))
    one, other = env.step(0), copy.step(0)
    np.testing.assert_array_equal(one[0]["tracks"]["ids"], other[0]["tracks"]["ids"])
    assert one[4]["scores"] == other[4]["scores"]
    assert one[0]["tracks"]["ids"].shape == (5,)


def test_many_at_once_are_scored() -> None:
    envs = gym.vector.SyncVectorEnv([lambda: Scored(TrackObservation(make()))] * 2)
    observation, _ = envs.reset(seed=3)
    assert observation["tracks"]["boxes"].shape == (2, 64, 4)
    *_, told = envs.step(np.zeros(2, int))
    assert told["scores"]["CLR_TP"].shape == (2,)
    envs.close()


def test_wrong_wrapping_is_refused() -> None:
    with pytest.raises(UnknownName, match=r"unknown tracker 'papper'.*Did you mean 'paper'"):
        TrackObservation(make(), "papper")
    with pytest.raises(BadConfig, match="max_tracks is 0"):
        TrackObservation(make(), max_tracks=0)
    with pytest.raises(BadConfig, match="wrap in TrackObservation before"):
        Scored(make())


def random_rows(rng: np.random.Generator, most: int, is_truth: bool) -> Tracks:
    """Boxes that overlap one another a lot, with gaps, vans and regions that do not count."""
    frames, ids = np.divmod(rng.permutation(CLEAR_FRAMES * 6)[: rng.integers(most + 1)], 6)
    order = np.argsort(frames, kind="stable")
    frames, ids = frames[order], ids[order]
    low = np.stack((40.0 * rng.permutation(6)[ids] * rng.integers(0, 2), 10.0 * ids), axis=1)
    low += rng.uniform(-6.0, 6.0, low.shape)
    boxes = np.concatenate((low, low + (60.0, 40.0)), axis=1)
    if not is_truth:
        return Tracks(frames, rng.permutation(9)[ids], boxes, np.ones(len(ids)))
    kinds = rng.choice(["Car", "Car", "Car", "Van", "DontCare"], len(ids))
    occlusion = rng.choice([0, 1, 3], len(ids))
    return Tracks(
        frames, np.where(kinds == "DontCare", -1, ids), boxes, None, kinds, None, occlusion
    )


@given(seed=st.integers(0, 10**6))
def test_the_sums_are_those_of_the_whole_sequence(seed) -> None:
    rng = np.random.default_rng(seed)
    truth, output = random_rows(rng, 40, True), random_rows(rng, 40, False)
    running = RunningClear()
    for frame in range(CLEAR_FRAMES):
        parts = (part.select(part.frames == frame) for part in (truth, output))
        running.add(*parts, frame)
    whole = evaluate_sequence(truth, output, CLEAR_FRAMES)
    for name, number in vars(running.total).items():
        assert number == whole[name], name
    assert counted_labels(truth, CLEAR_FRAMES) == whole["CLR_TP"] + whole["CLR_FN"]
    if len(truth) and len(output) and not whole.clear.one_sided:
        assert pytest.approx(whole["MOTA"], abs=1e-12) == running.total.MOTA


def test_nothing_counts_nothing() -> None:
    assert RunningClear().add(Tracks.empty(), Tracks.empty(), 0) == RunningCounts()
    assert RunningCounts().MOTA == 0.0


def test_a_name_that_changes_is_a_switch() -> None:
    box = np.array([[0.0, 0.0, 60.0, 60.0]])
    running = RunningClear()
    for frame, name in enumerate((4, 4, 5, 4)):
        frames = np.array([frame])
        running.add(
            Tracks(frames, np.array([1]), box), Tracks(frames, np.array([name]), box), frame
        )
    assert running.total == RunningCounts(CLR_TP=4, IDSW=2)
    assert running.total.MOTA == 0.5


def test_one_name_twice_in_a_frame_is_refused() -> None:
    box = np.zeros((2, 4))
    twice = Tracks(np.zeros(2, int), np.ones(2, int), box)
    with pytest.raises(BadTracks, match="stands twice"):
        RunningClear().add(Tracks.empty(), twice, 0)

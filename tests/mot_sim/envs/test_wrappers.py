"""Tracks in the observation, and their scores in the info."""

import pickle

import gymnasium as gym
import numpy as np
import pytest

import mot_sim  # noqa: F401  (registers the ids)
from mot_sim.envs.scene_env import Scored, TrackObservation
from mot_sim.metrics import evaluate_sequence
from mot_sim.simulation.episode import record
from mot_sim.simulation.registry import find_scene
from tracker import Tracker
from tracker.errors import BadConfig, UnknownName
from tracker.types import Tracks

FRAMES = 18


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

"""Who is who, decided by actions."""

import gymnasium as gym
import numpy as np
import pytest

from mot_sim.envs.association_env import (
    EMPTY_SLOT,
    AssociationEnv,
    Slots,
    decide,
    hungarian_policy,
)
from mot_sim.envs.errors import BadAction
from mot_sim.metrics import evaluate_sequence
from mot_sim.simulation.episodes import EpisodeFolder, record_episodes
from mot_sim.simulation.registry import find_scene
from tracker import TRACKERS, Tracks
from tracker.errors import BadConfig, DatasetNotFound, UnknownName

FRAMES = 40
NEW, REJECT = 64, 65


@pytest.fixture(scope="module")
def env() -> AssociationEnv:
    return AssociationEnv("crossing", frames=FRAMES, pool=1, tracker="paper")


def play(env: AssociationEnv, policy, episode: int = 0) -> tuple[float, dict]:
    """The return of an episode, and what was told last."""
    observation, told = env.reset(options={"episode": episode})
    total, ended = 0.0, False
    while not ended:
        observation, reward, ended, truncated, told = env.step(policy(observation))
        assert observation in env.observation_space
        assert not truncated
        total += reward
    return total, told


def score(env: AssociationEnv) -> float:
    drive = env._source.load(0)
    return evaluate_sequence(drive.truth, env.tracks, drive.frame_count)["MOTA"]


def test_the_hungarian_policy_returns_what_evaluate_gives_the_papers_tracker(env) -> None:
    total, told = play(env, hungarian_policy)
    drive = env._source.load(0)
    tracker = TRACKERS["paper"](drive.camera)
    expected = Tracks.concatenate([tracker.step(frame) for frame in drive])
    np.testing.assert_array_equal(env.tracks.frames, expected.frames)
    np.testing.assert_array_equal(env.tracks.ids, expected.ids)
    np.testing.assert_array_equal(env.tracks.boxes, expected.boxes)
    assert env.tracks.cuboids is not None
    assert expected.cuboids is not None
    np.testing.assert_array_equal(env.tracks.cuboids.base, expected.cuboids.base)
    whole = evaluate_sequence(drive.truth, expected, drive.frame_count)
    assert total == pytest.approx(whole["MOTA"], abs=1e-9)
    assert total > 0.5
    for name in ("CLR_TP", "CLR_FP", "CLR_FN", "IDSW"):
        assert told[name] == whole[name]


@pytest.mark.parametrize("tracker", sorted(TRACKERS))
@pytest.mark.parametrize("seed", [0, 1])
def test_the_return_is_the_mota_whatever_the_policy(env, tracker, seed) -> None:
    rng = np.random.default_rng(seed)
    other = AssociationEnv("crossing", frames=FRAMES, pool=1, tracker=tracker)
    other._source.kept.update(env._source.kept)

    def mostly_right(observation) -> np.ndarray:
        action = hungarian_policy(observation)
        wrong = rng.random(len(action)) < 0.2
        return np.where(wrong, rng.integers(0, 66, len(action)), action)

    total, _ = play(other, mostly_right)
    assert total == pytest.approx(score(other), abs=1e-9)


def test_nothing_found_returns_nothing(env) -> None:
    total, told = play(env, lambda _: np.full(64, REJECT))
    assert total == 0.0
    assert len(env.tracks) == 0
    assert told["refused"] == 0
    assert told["CLR_FN"] > 0


def test_everything_new_every_time_is_paid_for(env) -> None:
    total, told = play(env, lambda _: np.full(64, NEW))
    assert told["IDSW"] > 0
    assert total == pytest.approx(score(env), abs=1e-9)


def test_a_frame_is_decided_before_the_next_one_is_seen(env) -> None:
    observation, told = env.reset(options={"episode": 0})
    assert told["frame"] == 0
    assert not observation["tracks"].any()
    count = int(observation["detections"].sum())
    observation, *_, told = env.step(hungarian_policy(observation))
    assert told["frame"] == 1
    assert observation["tracks"].sum() == count
    assert (observation["costs"][observation["possible"] == 0] == 1.0).all()


def test_an_action_outside_the_space_is_refused(env) -> None:
    env.reset(seed=0)
    for action in (np.full(64, 66), np.full(3, 0), np.full(64, 0.5), np.full(64, -1)):
        with pytest.raises(BadAction, match="64 for a new track, 65 to reject"):
            env.step(action)


def test_of_two_detections_on_one_track_the_dearer_loses() -> None:
    costs = np.array([[0.4, 0.2, 0.2], [0.1, np.inf, 0.3]])
    match, refused = decide(np.array([5, 5, 5]), costs, np.array([5, 2]), 8)
    assert match.pairs.tolist() == [[0, 1]]
    assert match.unmatched_tracks.tolist() == [1]
    assert match.unmatched_detections.tolist() == []
    assert refused == 2


def test_an_empty_slot_and_an_impossible_pair_are_refused() -> None:
    costs = np.array([[0.4, np.inf]])
    match, refused = decide(np.array([3, 0]), costs, np.array([0]), 8)
    assert len(match.pairs) == 0
    assert refused == 2
    match, refused = decide(np.array([8, 9]), costs, np.array([0]), 8)
    assert (match.unmatched_detections.tolist(), refused) == ([0], 0)


def test_where_no_slot_is_free_nobody_is_new() -> None:
    match, refused = decide(np.array([2, 2, 2]), np.zeros((1, 3)), np.array([1]), 2)
    assert (match.unmatched_detections.tolist(), refused) == ([0], 2)


def test_nothing_is_decided_of_nothing() -> None:
    nothing = np.zeros(0, np.int64)
    match, refused = decide(nothing, np.zeros((0, 0)), nothing, 4)
    assert (len(match.pairs), len(match.unmatched_detections), refused) == (0, 0, 0)


def test_a_track_keeps_its_slot_while_it_lives() -> None:
    slots = Slots.empty(4).after(np.array([7, 9, 11]))
    assert slots.ids.tolist() == [7, 9, 11, EMPTY_SLOT]
    slots = slots.after(np.array([7, 11, 12]))
    assert slots.ids.tolist() == [7, 12, 11, EMPTY_SLOT]
    assert slots.of(np.array([12, 7, 11])).tolist() == [1, 0, 2]
    assert slots.taken.tolist() == [True, True, True, False]


def test_few_slots_and_rows_are_enough_to_go_on() -> None:
    env = AssociationEnv("crossing", frames=10, pool=1, max_detections=3, max_tracks=2)
    play(env, hungarian_policy)
    assert np.unique(env.tracks.frames, return_counts=True)[1].max() <= 2


def test_a_folder_of_episodes_is_played(tmp_path, env) -> None:
    folder = EpisodeFolder.open(tmp_path / "tree", {}, 2, 8)
    record_episodes(find_scene("crossing", frames=8), 3, folder)
    stored = AssociationEnv(episodes=str(tmp_path / "tree"), tracker="paper")
    total, told = play(stored, hungarian_policy, episode=1)
    fresh = AssociationEnv("crossing", frames=8, pool=5, tracker="paper")
    assert total == play(fresh, hungarian_policy, episode=4)[0]
    assert told["frame"] == 8
    with pytest.raises(BadConfig, match="episode 2: there are 0 to 1"):
        stored.reset(options={"episode": 2})


@pytest.mark.parametrize(
    ("options", "error", "told"),
    [
        ({"tracker": "papper"}, UnknownName, "Did you mean 'paper'"),
        ({"scene": "crosing"}, UnknownName, "Did you mean 'crossing'"),
        ({"framess": 3}, UnknownName, "Did you mean 'frames'"),
        ({"pool": 0}, BadConfig, "pool of 0 episodes"),
        ({"max_tracks": 0}, BadConfig, "max_tracks is 0"),
        ({"render_mode": "human"}, BadConfig, "nothing is drawn"),
        ({"episodes": "nowhere"}, DatasetNotFound, "no episodes in it"),
        ({"episodes": "nowhere", "frames": 3}, BadConfig, "no knobs left"),
    ],
)
def test_wrong_options_are_refused_at_once(options, error, told) -> None:
    with pytest.raises(error, match=told):
        AssociationEnv(**options)


def test_unknown_options_of_reset_are_refused() -> None:
    env = gym.make("mot_sim/Association-v0", frames=3, pool=1)
    with pytest.raises(UnknownName, match=r"option of reset 'episodes'.*Did you mean 'episode'"):
        env.reset(options={"episodes": 1})

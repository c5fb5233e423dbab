"""Who is who, decided by actions."""

import gymnasium as gym
import numpy as np
import pytest

from mot_sim.envs.association_actions import EMPTY_SLOT, Slots, decide, mask_of
from mot_sim.envs.association_env import AssociationEnv
from mot_sim.envs.association_experts import (
    disjoint_pools,
    greedy_policy,
    hungarian_policy,
    imitation_dataset,
)
from mot_sim.envs.association_observation import pair_features
from mot_sim.envs.errors import BadAction, OutOfTurn
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
    observation, told = env.reset(options={"episode_number": episode})
    total, ended = 0.0, False
    while not ended:
        observation, reward, ended, truncated, told = env.step(policy(observation))
        assert observation in env.observation_space
        assert not truncated
        total += reward
    return total, told


def score(env: AssociationEnv) -> float:
    drive = env.source.load(0)
    return evaluate_sequence(drive.truth, env.tracks, drive.frame_count)["MOTA"]


def test_the_hungarian_policy_returns_what_evaluate_gives_the_papers_tracker(env) -> None:
    total, told = play(env, hungarian_policy)
    drive = env.source.load(0)
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
    other.source.kept.update(env.source.kept)

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
    observation, told = env.reset(options={"episode_number": 0})
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
    assert refused.tolist() == [True, False, True]


def test_an_empty_slot_and_an_impossible_pair_are_refused() -> None:
    costs = np.array([[0.4, np.inf]])
    match, refused = decide(np.array([3, 0]), costs, np.array([0]), 8)
    assert len(match.pairs) == 0
    assert refused.all()
    match, refused = decide(np.array([8, 9]), costs, np.array([0]), 8)
    assert (match.unmatched_detections.tolist(), refused.tolist()) == ([0], [False, False])


def test_where_no_slot_is_free_nobody_is_new() -> None:
    match, refused = decide(np.array([2, 2, 2]), np.zeros((1, 3)), np.array([1]), 2)
    assert (match.unmatched_detections.tolist(), refused.tolist()) == ([0], [False, True, True])


def test_nothing_is_decided_of_nothing() -> None:
    nothing = np.zeros(0, np.int64)
    match, refused = decide(nothing, np.zeros((0, 0)), nothing, 4)
    assert (len(match.pairs), len(match.unmatched_detections), len(refused)) == (0, 0, 0)


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
    with pytest.raises(BadConfig, match="episode_number 2: there are 0 to 1"):
        stored.reset(options={"episode_number": 2})


@pytest.mark.parametrize(
    ("options", "error", "told"),
    [
        ({"tracker": "papper"}, UnknownName, "Did you mean 'paper'"),
        ({"scene": "crosing"}, UnknownName, "Did you mean 'crossing'"),
        ({"framess": 3}, UnknownName, "Did you mean 'frames'"),
        ({"pool": 0}, BadConfig, "pool of 0 episodes"),
        ({"max_tracks": 0}, BadConfig, "max_tracks is 0"),
        ({"render_mode": "ansi"}, UnknownName, "unknown render mode 'ansi'"),
        ({"first_seed": -1}, BadConfig, "first_seed is -1"),
        ({"penalty": -0.1}, BadConfig, "penalty is -0.1"),
        ({"episodes": "nowhere"}, DatasetNotFound, "no episodes in it"),
        ({"episodes": "nowhere", "frames": 3}, BadConfig, "drop \\['frames'\\]"),
    ],
)
def test_wrong_options_are_refused_at_once(options, error, told) -> None:
    with pytest.raises(error, match=told):
        AssociationEnv(**options)


def test_unknown_options_of_reset_are_refused() -> None:
    env = gym.make("mot_sim/Association-v0", frames=3, pool=1)
    with pytest.raises(
        UnknownName, match=r"option of reset 'episode'.*Did you mean 'episode_number'"
    ):
        env.reset(options={"episode": 1})


def test_no_choice_that_the_mask_leaves_is_refused_alone(env) -> None:
    env.reset(options={"episode_number": 0})
    rng = np.random.default_rng(0)
    for _ in range(10):
        mask = env.action_masks().reshape(64, 66)
        assert mask.any(axis=1).all()
        chosen = int(rng.integers(5))  # one detection chooses, so that no two want the same
        action = np.full(64, REJECT)
        action[chosen] = rng.choice(np.flatnonzero(mask[chosen]))
        assert env.step(action)[4]["refused"] == 0
        outside = np.flatnonzero(~env.action_masks().reshape(64, 66)[0])
        assert len(outside)


def test_the_mask_by_hand() -> None:
    possible = np.array([[True, False, True], [False, False, True]])
    mask = mask_of(possible, np.array([True, False]), np.array([True, True, False]))
    assert mask.astype(int).tolist() == [[1, 0, 1, 1], [0, 0, 1, 1], [0, 0, 0, 1]]
    full = mask_of(possible, np.array([True, True]), np.array([True, True, True]))
    assert full[:, 2].tolist() == [False, False, False]


def test_features_of_pairs_do_not_depend_on_the_order() -> None:
    costs = np.array([[0.2, 0.6, np.inf], [0.1, 0.3, 0.5]])
    predicted = np.array([[0.0, 0.0, 10.0, 10.0], [5.0, 0.0, 15.0, 10.0]])
    boxes = np.array([[0.0, 0.0, 10.0, 10.0], [5.0, 0.0, 15.0, 10.0], [50.0, 0.0, 60.0, 10.0]])
    features = pair_features(costs, predicted, boxes)
    np.testing.assert_allclose(features[0, 0], [0.8, 1.0, 1.0, 0.5])
    np.testing.assert_allclose(features[1, 2], [0.5, 0.0, 1.0 / 3.0, 1.0])
    assert not features[0, 2].any()
    rows, columns = [1, 0], [2, 0, 1]
    other = pair_features(costs[rows][:, columns], predicted[rows], boxes[columns])
    np.testing.assert_array_equal(other, features[rows][:, columns])


def test_a_penalty_is_taken_for_what_is_refused(env) -> None:
    fined = AssociationEnv("crossing", frames=FRAMES, pool=1, tracker="paper", penalty=0.5)
    fined.source.kept.update(env.source.kept)
    everything = np.zeros(64, np.int64)  # all on the first slot, which is empty
    refused, rewards = [], []
    for one in (env, fined):
        one.reset(options={"episode_number": 0})
        _, reward, *_, told = one.step(everything)
        refused.append(told["refused"])
        rewards.append(reward)
    assert refused[0] == refused[1] > 0
    assert rewards[0] - rewards[1] == pytest.approx(0.5 * refused[0] / env._labelled)


def test_the_decision_is_drawn(env) -> None:
    drawn = AssociationEnv(
        "crossing", frames=FRAMES, pool=1, tracker="paper", render_mode="rgb_array"
    )
    drawn.source.kept.update(env.source.kept)
    drawn.reset(options={"episode_number": 0})
    undecided = drawn.render()
    drawn.step(drawn.expert_action())
    new = drawn.render()
    drawn.step(np.zeros(64, np.int64))
    refused = drawn.render()
    assert new.shape == refused.shape == undecided.shape
    red = [(image == (255, 48, 40)).all(axis=2).sum() for image in (undecided, new, refused)]
    assert red[0] == red[1] == 0 < red[2]
    assert (new != undecided).any()
    env.reset(options={"episode_number": 0})
    with pytest.warns(UserWarning, match="render_mode='rgb_array'"):
        assert env.render() is None


def test_experts_act_and_become_a_data_set(env) -> None:
    total, _ = play(env, greedy_policy)
    observation, _ = env.reset(options={"episode_number": 0})
    np.testing.assert_array_equal(env.expert_action(), hungarian_policy(observation))
    imitated = imitation_dataset(env, "greedy")
    assert imitated.returns.tolist() == [total]
    assert imitated.actions.shape == (FRAMES, 64)
    assert imitated.observations["pairs"].shape == (FRAMES, 64, 64, 4)
    chosen = np.take_along_axis(
        imitated.masks.reshape(FRAMES, 64, 66), imitated.actions[:, :, None], axis=2
    )
    assert chosen.all()
    with pytest.raises(OutOfTurn, match="greedy expert was asked after the end, frame 40"):
        env.expert_action("greedy")
    with pytest.raises(UnknownName, match="Did you mean 'hungarian'"):
        imitation_dataset(env, "hungary")
    with pytest.raises(BadConfig, match="2 episodes for imitation: the pool has 1"):
        imitation_dataset(env, episodes=2)


def test_pools_are_apart() -> None:
    assert disjoint_pools(range(3), range(10, 12)) == (
        {"first_seed": 0, "pool": 3},
        {"first_seed": 10, "pool": 2},
    )
    with pytest.raises(BadConfig, match="share seeds 2 to 2"):
        disjoint_pools(range(3), range(2, 5))
    with pytest.raises(BadConfig, match=r"test pool range\(5, 5\)"):
        disjoint_pools(range(3), range(5, 5))
    later = AssociationEnv("crossing", frames=4, first_seed=7, pool=1)
    later.reset(seed=0)
    assert later.source.load(0).seed == 7

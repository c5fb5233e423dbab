"""Many episodes of data association at once are so many single ones, step by step."""

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from gymnasium.wrappers.vector import RecordEpisodeStatistics

import mot_sim  # noqa: F401 - registers the ids
from mot_sim.envs.association_env import AssociationEnv
from mot_sim.envs.association_vector_env import AssociationVectorEnv
from mot_sim.envs.errors import BadAction, OutOfTurn
from tracker.errors import BadConfig, UnknownName

ID = "mot_sim/Association-v0"
SMALL = {"frames": 12, "pool": 3, "max_tracks": 9, "max_detections": 8}


def drawn(rng: np.random.Generator, env: AssociationVectorEnv) -> np.ndarray:
    """What experts do, what the masks leave, or anything, each in a third of the environments."""
    masks = env.action_masks().reshape(env.num_envs, env.one.max_detections, -1)
    choices = (
        env.expert_actions(),
        (rng.random(masks.shape) * masks).argmax(axis=2),
        rng.integers(0, env.one.max_tracks + 2, masks.shape[:2]),
    )
    return np.stack(choices)[rng.integers(3, size=env.num_envs), np.arange(env.num_envs)]


def same(one: object, other: object) -> None:
    """Fail unless two nested structures of arrays hold the same numbers of the same types."""
    if isinstance(one, dict):
        assert one.keys() == other.keys()
        for key in one:
            same(one[key], other[key])
    elif isinstance(one, tuple) or (isinstance(one, np.ndarray) and one.dtype == object):
        for mine, theirs in zip(one, other, strict=True):
            same(mine, theirs)
    elif isinstance(one, np.ndarray):
        assert (one.dtype, one.shape) == (other.dtype, other.shape)
        np.testing.assert_array_equal(one, other)
    else:
        assert one == other


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"scene": "highway", "penalty": 0.5, "max_tracks": 4},
        {"scene": "street", "tracker": "paper", "first_seed": 5},
        {"scene": "street", "profile": "cues"},
    ],
)
@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_episodes_at_once_are_single_ones_step_by_step(options, mode) -> None:
    made = SMALL | options
    ours = AssociationVectorEnv(5, autoreset_mode=mode, **made)
    theirs = SyncVectorEnv([lambda: AssociationEnv(**made)] * 5, autoreset_mode=mode)
    for env in theirs.envs:
        env.source = ours.one.source
    assert ours.observation_space == theirs.observation_space
    assert ours.action_space == theirs.action_space
    rng = np.random.default_rng(0)
    same(ours.reset(seed=3), theirs.reset(seed=3))
    for _ in range(30):
        masks = np.stack([env.action_masks() for env in theirs.envs])
        np.testing.assert_array_equal(ours.action_masks(), masks)
        action = drawn(rng, ours)
        same(ours.step(action), theirs.step(action))


def test_sixty_four_episodes_return_what_single_ones_return() -> None:
    envs = gym.make_vec(ID, num_envs=64, vectorization_mode="vector_entry_point", **SMALL)
    assert isinstance(envs.unwrapped, AssociationVectorEnv)
    one = AssociationEnv(**SMALL)
    one.source = envs.unwrapped.one.source
    numbers = np.arange(64) % 3
    envs.reset(seed=0, options={"episode_number": numbers})
    returns, rng, over = np.zeros(64), np.random.default_rng(1), np.zeros(64, bool)
    actions: list[np.ndarray] = []
    while not over.all():
        actions.append(drawn(rng, envs.unwrapped))
        _, rewards, terminated, _, infos = envs.step(actions[-1])
        returns += rewards
        over |= terminated
    for drive in range(64):
        one.reset(options={"episode_number": int(numbers[drive])})
        steps = [one.step(action[drive]) for action in actions]
        assert returns[drive] == sum(step[1] for step in steps)
        assert infos["MOTA"][drive] == steps[-1][4]["MOTA"]
    assert np.abs(returns - infos["MOTA"]).max() < 1e-9


def test_a_seed_draws_the_same_episodes_and_a_list_gives_each_its_own() -> None:
    envs = AssociationVectorEnv(4, **SMALL)
    first = envs.reset(seed=7)[1]["episode_number"].tolist()
    later = envs.reset()[1]["episode_number"].tolist()
    assert envs.reset(seed=[7, 8, 9, 10])[1]["episode_number"].tolist() == first
    assert envs.reset()[1]["episode_number"].tolist() == later
    alone = [AssociationEnv(**SMALL).reset(seed=7 + at)[1]["episode_number"] for at in range(4)]
    assert first == alone


def test_a_mask_begins_only_what_has_ended() -> None:
    envs = AssociationVectorEnv(2, autoreset_mode="Disabled", **SMALL | {"pool": 1})
    envs.reset(seed=0)
    for _ in range(12):
        *_, terminated, _, _ = envs.step(envs.expert_actions())
    assert terminated.all()
    with pytest.raises(OutOfTurn, match=r"a step after the end of \[0, 1\]: call reset"):
        envs.step(np.zeros((2, 8), int))
    with pytest.raises(OutOfTurn, match="hungarian expert was asked after the end"):
        envs.expert_actions()
    _, info = envs.reset(options={"reset_mask": np.array([False, True])})
    assert info["_frame"].tolist() == [False, True]
    assert envs.is_over.tolist() == [True, False]


def test_gymnasiums_statistics_take_it() -> None:
    envs = RecordEpisodeStatistics(AssociationVectorEnv(3, **SMALL))
    envs.reset(seed=1)
    for _ in range(12):
        _, _, terminated, _, infos = envs.step(envs.unwrapped.expert_actions())
    assert terminated.all()
    np.testing.assert_allclose(infos["episode"]["r"], infos["MOTA"])
    assert infos["episode"]["l"].tolist() == [12, 12, 12]
    assert np.array(envs.unwrapped.call("action_masks")).shape == (3, 8 * 11)


def test_pictures_are_those_of_single_environments() -> None:
    made = SMALL | {"render_mode": "rgb_array"}
    envs, one = AssociationVectorEnv(2, **made), AssociationEnv(**made)
    one.source = envs.one.source
    envs.reset(options={"episode_number": np.array([1, 2])})
    one.reset(options={"episode_number": 2})
    for _ in range(3):
        action = envs.expert_actions()
        envs.step(action)
        one.step(action[1])
        np.testing.assert_array_equal(envs.render()[1], one.render())
    assert AssociationVectorEnv(1, **SMALL).render_mode is None


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({"num_envs": 0}, "num_envs is 0: give 1 to"),
        ({"num_envs": -1}, "num_envs is -1"),
        ({"num_envs": 2.0}, "num_envs is 2.0"),
        ({"pool": 0}, "a pool of 0 episodes"),
        ({"max_tracks": 0}, "max_tracks is 0"),
        ({"penalty": -1.0}, "penalty is -1"),
        ({"render_mode": "human"}, "'human' opens a window.*'sync'"),
        ({"autoreset_mode": "later"}, "autoreset_mode is 'later': give one of"),
    ],
)
def test_arguments_that_cannot_be_are_named(arguments, told) -> None:
    with pytest.raises(BadConfig, match=told):
        AssociationVectorEnv(**{"num_envs": 2} | SMALL | arguments)


@pytest.mark.parametrize(
    ("action", "told"),
    [
        (np.zeros((2, 7), int), r"actions of shape \(2, 7\).*shape \(3, 8\)"),
        (np.zeros(8, int), r"actions of shape \(8,\)"),
        (np.zeros((3, 8)), "of shape .* type float64: give whole numbers"),
        (np.full((3, 8), 11), "action 11 of environment 0 for detection 0: give slots 0 to 8, 9"),
        (np.full((3, 8), -1), "action -1 of environment 0"),
        (None, "actions of shape"),
    ],
)
def test_an_action_that_is_none_is_named(action, told) -> None:
    envs = AssociationVectorEnv(3, **SMALL)
    with pytest.raises(OutOfTurn, match="nothing has begun"):
        envs.step(action)
    envs.reset(seed=0)
    with pytest.raises(BadAction, match=told):
        envs.step(action)


@pytest.mark.parametrize(
    ("asked", "error", "told"),
    [
        ({"options": {"episode": 1}}, UnknownName, "option of reset.*'episode'"),
        ({"options": {"episode_number": 3}}, BadConfig, "episode_number 3: there are 0 to 2"),
        ({"options": {"episode_number": np.zeros(2, int)}}, BadConfig, "give a number, or 3"),
        ({"options": {"reset_mask": np.zeros(3, bool)}}, BadConfig, "one of them true"),
        ({"options": {"reset_mask": [1, 0, 0]}}, BadConfig, "give 3 booleans"),
        ({"options": {"reset_mask": np.eye(3, dtype=bool)[0]}}, OutOfTurn, "reset all first"),
        ({"seed": [1, 2]}, BadConfig, "2 seeds for 3 environments"),
    ],
)
def test_a_reset_that_cannot_be_is_named(asked, error, told) -> None:
    with pytest.raises(error, match=told):
        AssociationVectorEnv(3, **SMALL).reset(**asked)


def test_only_what_is_known_can_be_called() -> None:
    envs = AssociationVectorEnv(1, **SMALL)
    for asked in (envs.action_masks, lambda: AssociationVectorEnv(1, **SMALL).render()):
        with pytest.raises(OutOfTurn, match="nothing has begun"):
            asked()
    envs.reset(seed=0)
    with pytest.raises(BadConfig, match="'reward_range' cannot be called: known are action_masks"):
        envs.call("reward_range")
    with pytest.raises(UnknownName, match="expert"):
        envs.expert_actions("hungary")

"""What holds for every Gymnasium id that is registered, whatever the scene."""

import pickle
import subprocess
import sys
from hashlib import sha256
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import spaces
from gymnasium.utils.env_checker import check_env

import mot_sim  # noqa: F401  (registers the ids)
from mot_sim.envs.driving_tasks import META_ACTIONS
from mot_sim.envs.errors import BadAction, OutOfTurn
from mot_sim.envs.registration import ANY_SCENE, environment_id
from mot_sim.simulation.registry import SCENES, knobs_of
from tracker.errors import BadConfig, UnknownName

ASSOCIATION = "mot_sim/Association-v0"
SCENE_OF = {environment_id(name): name for name in SCENES} | {ANY_SCENE: "crossing"}
IDS = sorted(name for name in gym.registry if name.startswith("mot_sim/"))
# As little as a scene can be asked for, so that all of this takes seconds.
LITTLE = {
    "cars": 3, "arrivals": 0.2, "parked": 0.1, "vans": 0,
    "houses": 0.0, "trees": 0.0, "furniture": 0.0,
}  # fmt: skip
# With pictures in every run; the others' worlds take seconds: in the long run alone.
DRAWN = {ASSOCIATION, "mot_sim/Crossing-v0"}
SEED = 123  # the one that Gymnasium's own checks use


def options(name: str) -> dict[str, Any]:
    """A short, small and sparse version of what an id gives."""
    if name == ASSOCIATION:
        return {
            "frames": 4, "pool": 2, "max_detections": 8, "max_tracks": 8,
            "houses": 0.0, "trees": 0.0, "furniture": 0.0,
        }  # fmt: skip
    known = knobs_of(SCENE_OF[name])
    sparse = {knob: value for knob, value in LITTLE.items() if knob in known}
    if name == "mot_sim/IntersectionDoubleParked-v0":
        sparse["vans"] = 1  # the fewest: one is double-parked
    return {"frames": 4, "scale": 0.2, "image": False, "max_detections": 8, **sparse}


def make(name: str, **more: Any) -> gym.Env:
    return gym.make(name, **{**options(name), **more})


def leaves(value: Any) -> list[np.ndarray]:
    """All arrays of an observation, in the order of their names."""
    if isinstance(value, dict):
        return [leaf for key in sorted(value) for leaf in leaves(value[key])]
    return [np.asarray(value)]


def play(env: gym.Env, seed: int | None, steps: int = 3) -> list[np.ndarray]:
    """All that is observed, and the rewards, under the same actions every time."""
    env.action_space.seed(3)
    seen = leaves(env.reset(seed=seed)[0])
    for _ in range(steps):
        observation, reward, *_ = env.step(env.action_space.sample())
        seen += [*leaves(observation), np.array(reward)]
    return seen


def digest(name: str) -> str:
    env = make(name)
    played = sha256(b"".join(array.tobytes() for array in play(env, seed=SEED)))
    env.close()
    return played.hexdigest()


def boxes_of(space: spaces.Space) -> list[spaces.Box]:
    if isinstance(space, spaces.Dict):
        return [box for part in space.values() for box in boxes_of(part)]
    return [space] if isinstance(space, spaces.Box) else []


def test_there_is_an_id_for_every_scene() -> None:
    assert sorted([*SCENE_OF, ASSOCIATION]) == IDS
    assert "mot_sim/TJunction-v0" in IDS


@pytest.mark.parametrize("name", sorted({*IDS} - DRAWN))
def test_gymnasium_finds_nothing_wrong(name) -> None:
    env = make(name)
    check_env(env.unwrapped, skip_render_check=True)
    env.close()


@pytest.mark.parametrize("name", IDS)
def test_a_seed_is_an_episode_and_no_seed_is_the_next_one(name) -> None:
    env = make(name, **({"pool": 10**6} if name == ASSOCIATION else {}))

    def numbers(seed: int) -> list[Any]:
        key = "episode_number" if name == ASSOCIATION else "episode_seed"
        first = env.reset(seed=seed)[1][key]
        return [first, *(env.reset()[1][key] for _ in range(1))]

    once, again, other = numbers(SEED), numbers(SEED), numbers(456)
    assert once == again
    assert once[0] != once[1]
    assert once != other


def test_every_id_plays_the_same_in_another_process() -> None:
    code = (
        "from tests.contracts.test_environments import IDS, digest\n"
        "print(*(digest(name) for name in IDS))"
    )
    told = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120
    )
    assert told.stdout.split() == [digest(name) for name in IDS]


@pytest.mark.parametrize("name", IDS)
def test_many_at_once_see_what_one_sees(name) -> None:
    made = [lambda: make(name)] * 2
    one = make(name)
    seen: list[list[np.ndarray]] = []
    for kind in (gym.vector.SyncVectorEnv, gym.vector.AsyncVectorEnv):
        envs = kind(made)
        observation, told = envs.reset(seed=[SEED, SEED + 1])
        envs.action_space.seed(0)
        after, _, _, _, told_after = envs.step(envs.action_space.sample())
        assert told.keys() == told_after.keys()
        seen.append([*leaves(observation), *leaves(after)])
        envs.close()
    for synchronous, asynchronous in zip(*seen, strict=True):
        np.testing.assert_array_equal(synchronous, asynchronous)
    for alone, both in zip(leaves(one.reset(seed=SEED)[0]), seen[0], strict=False):
        np.testing.assert_array_equal(alone, both[0])


@pytest.mark.parametrize("name", IDS)
def test_a_pickled_environment_goes_on_where_it_was(name) -> None:
    env = make(name).unwrapped
    env.action_space.seed(1)
    env.reset(seed=SEED)
    env.step(env.action_space.sample())
    copy = pickle.loads(pickle.dumps(env))
    assert copy.spec == env.spec
    for step in range(2):
        action = env.action_space.sample()
        np.testing.assert_array_equal(copy.action_space.sample(), action)
        one, other = env.step(action), copy.step(action)
        assert one[1:4] == other[1:4], step
        for first, second in zip(leaves(one[0]), leaves(other[0]), strict=True):
            np.testing.assert_array_equal(first, second)
    first, second = env.reset()[1], copy.reset()[1]
    assert first == second


@pytest.mark.parametrize("name", IDS)
def test_bounds_are_finite_and_told_keys_stay(name) -> None:
    env = make(name)
    for box in boxes_of(env.observation_space):
        assert np.isfinite(box.low).all()
        assert np.isfinite(box.high).all()
    _, told = env.reset(seed=SEED)
    assert env.step(env.action_space.sample())[4].keys() == told.keys()
    assert not {"truth", "labels"} & env.observation_space.keys()


@pytest.mark.parametrize("name", IDS)
def test_metadata_belong_to_the_instance(name) -> None:
    one, other = make(name).unwrapped, make(name).unwrapped
    one.metadata["render_modes"].append("smoke")
    assert "smoke" not in other.metadata["render_modes"]
    assert "smoke" not in type(one).metadata["render_modes"]


@pytest.mark.parametrize("name", IDS)
def test_it_closes_twice_and_begins_again(name) -> None:
    env = make(name).unwrapped
    env.close()
    before = play(env, seed=SEED)
    env.close()
    env.close()
    for first, second in zip(before, play(env, seed=SEED), strict=True):
        np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize("name", IDS)
def test_steps_out_of_turn_and_actions_outside_are_refused(name) -> None:
    env = make(name).unwrapped
    with pytest.raises(OutOfTurn, match=r"call reset\(\) first"):
        env.step(env.action_space.sample())
    env.reset(seed=SEED)
    for outside in (-1, 99, "left", None):
        with pytest.raises(BadAction, match=r"is not in .*iscrete"):
            env.step(outside)
    ended = False
    while not ended:
        _, _, terminated, truncated, _ = env.step(env.action_space.sample())
        ended = terminated or truncated
    with pytest.raises(OutOfTurn, match="after the end"):
        env.step(env.action_space.sample())


@pytest.mark.parametrize("name", IDS)
def test_a_wrong_knob_gets_a_hint(name) -> None:
    with pytest.raises(UnknownName, match=r"unknown .*'framess'.*Did you mean 'frames'"):
        gym.make(name, framess=3)
    with pytest.raises(BadConfig, match="frames"):
        gym.make(name, frames=-3)


@pytest.mark.parametrize("name", sorted(SCENE_OF))
def test_driving_is_offered_where_traffic_is_live(name) -> None:
    try:
        env = make(name, traffic="live")
    except BadConfig as error:
        assert "has no live traffic" in str(error)  # noqa: PT017
        return
    assert env.action_space == spaces.Discrete(len(META_ACTIONS))
    env.reset(seed=SEED)
    for action in range(3):
        _, reward, _, _, told = env.step(action)
        assert told["crashed"] or 0.0 <= reward <= 1.0


def test_a_wrong_scene_gets_a_hint() -> None:
    with pytest.raises(gym.error.NameNotFound, match="Did you mean: `Crossing`"):
        gym.make("mot_sim/Crosing-v0")


def test_ids_are_found_by_the_name_of_the_module_too() -> None:
    code = (
        "import gymnasium as gym, sys\n"
        "env = gym.make('mot_sim:mot_sim/Crossing-v0', frames=3, image=False, renderer='mesh')\n"
        "env.reset(seed=0)\n"
        "env.step(0)\n"
        "print({'OpenGL', 'pyrender', 'pygame', 'highway_env', 'matplotlib'} & {*sys.modules})"
    )
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert (done.stdout.strip(), done.stderr) == ("set()", "")


def test_registering_again_changes_nothing(recwarn) -> None:
    from mot_sim.envs.registration import register_environments

    before = dict(gym.registry)
    register_environments()
    assert gym.registry == before
    assert not recwarn

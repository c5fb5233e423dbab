"""Gymnasium's own wrappers and vectors take every id that is registered."""

from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import wrappers
from gymnasium.envs.registration import EnvSpec
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from tests.contracts.test_environments import ASSOCIATION, DRAWN, IDS, SCENE_OF, SEED, make
from tracker.errors import BadConfig

LIVE = {"mot_sim/Highway-v0": {"actions": "continuous", "observation": "kinematics"}}


@pytest.mark.parametrize("name", IDS)
def test_wrappers_stand_on_one_another(name: str) -> None:
    env = wrappers.RecordEpisodeStatistics(wrappers.TimeLimit(make(name), 2))
    env = wrappers.FrameStackObservation(wrappers.FlattenObservation(env), 3)
    seen, _ = env.reset(seed=SEED)
    assert seen in env.observation_space
    for step in (1, 2):
        seen, _, terminated, truncated, info = env.step(env.action_space.sample())
        assert seen in env.observation_space
        assert (terminated, truncated) == (False, step == 2)
    assert info["episode"]["l"] == 2
    copied = EnvSpec.from_json(make(name).spec.to_json())
    assert copied == make(name).spec


@pytest.mark.parametrize(
    "name", [name if name in DRAWN else pytest.param(name, marks=pytest.mark.slow) for name in IDS]
)
def test_gymnasium_finds_nothing_wrong_where_pictures_are_drawn(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    check_env(make(name, render_mode="rgb_array").unwrapped)


@pytest.mark.parametrize("name", [ASSOCIATION, "mot_sim/Crossing-v0", *LIVE])
@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_vectors_begin_again_by_themselves(name: str, mode: AutoresetMode) -> None:
    made = [lambda: make(name, frames=3, **LIVE.get(name, {}))] * 2
    envs = wrappers.vector.RecordEpisodeStatistics(SyncVectorEnv(made, autoreset_mode=mode))
    envs.reset(seed=SEED)
    envs.action_space.seed(1)
    frames, lengths = [], []
    for _ in range(4):
        *_, info = envs.step(envs.action_space.sample())
        frames.append(info["frame"].tolist())
        if "episode" in info:
            lengths.append(int(info["episode"]["l"].max()))
    # An episode of a scene has one step fewer than frames; the association decides on each.
    last = 3 if name == ASSOCIATION else 2
    assert lengths[0] == last
    begun = (
        last - 1 if mode is AutoresetMode.SAME_STEP else last
    )  # index of the step after which it is frame 0
    assert frames[begun] == [0, 0]


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(DRAWN))
def test_videos_are_recorded(name: str, tmp_path: Any) -> None:
    pytest.importorskip("moviepy")
    env = make(name, render_mode="rgb_array")
    env = wrappers.RecordVideo(env, str(tmp_path / "videos"), episode_trigger=lambda _: True)
    env.reset(seed=SEED)
    over = False
    while not over:
        _, _, terminated, truncated, _ = env.step(env.action_space.sample())
        over = terminated or truncated
    env.close()
    assert [path.suffix for path in (tmp_path / "videos").iterdir()] == [".mp4"]


def driven(name: str) -> dict[str, Any]:
    """A live, small version of an id; recorded where its scene cannot answer."""
    from mot_sim.envs.rollouts import driver_of
    from mot_sim.simulation.registry import find_scene
    from tracker.errors import BadConfig

    if name == ASSOCIATION:
        return {}
    try:
        driver_of(find_scene(SCENE_OF[name]), 0)
    except BadConfig:
        return {}
    return {"traffic": "live"}


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", IDS)
def test_stable_baselines_checks_and_learns(name: str) -> None:
    pytest.importorskip("stable_baselines3")
    from stable_baselines3 import PPO
    from stable_baselines3.common.env_checker import check_env as check_for_sb3
    from stable_baselines3.common.monitor import Monitor

    env = make(name, **driven(name))
    check_for_sb3(env.unwrapped, skip_render_check=True)
    model = PPO("MultiInputPolicy", Monitor(env), n_steps=8, batch_size=8, n_epochs=1)
    before = [part.clone() for part in model.policy.parameters()]
    model.learn(16)
    assert any((a != b).any() for a, b in zip(before, model.policy.parameters(), strict=True))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_stable_baselines_learns_of_many_episodes_at_once() -> None:
    pytest.importorskip("sb3_contrib")
    from sb3_contrib import MaskablePPO
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import VecMonitor

    from mot_sim.envs.stable_baselines import StableBaselinesEpisodes

    sizes = {"frames": 4, "pool": 2, "max_tracks": 6, "max_detections": 6}
    for kind in (PPO, MaskablePPO):
        episodes = VecMonitor(StableBaselinesEpisodes(3, **sizes))
        model = kind("MultiInputPolicy", episodes, n_steps=8, batch_size=8, n_epochs=1, seed=SEED)
        model.learn(24)
        ended = [episode["l"] for episode in model.ep_info_buffer]
        assert ended == [4] * 6
    episodes = StableBaselinesEpisodes(2, **sizes)
    episodes.seed(SEED)
    seen = episodes.reset()
    assert seen["boxes"].shape == (2, 6, 4)
    for _ in range(4):
        action = np.array(episodes.env_method("expert_action"))
        _, _, dones, infos = episodes.step(action)
    assert dones.all()
    for info in infos:
        assert info["frame"] == 4
        assert info["terminal_observation"]["tracks"].sum() == 0
    assert episodes.get_attr("pool") == [2, 2]
    with pytest.raises(BadConfig, match="penalty cannot be set"):
        episodes.set_attr("penalty", 1.0)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_masks_are_taken_by_maskable_ppo() -> None:
    pytest.importorskip("sb3_contrib")
    from sb3_contrib import MaskablePPO

    env: gym.Env = make(ASSOCIATION)
    model = MaskablePPO("MultiInputPolicy", env, n_steps=8, batch_size=8, n_epochs=1)
    model.learn(16)
    seen, _ = env.reset(seed=SEED)
    masks = env.unwrapped.action_masks()
    action, _ = model.predict(seen, action_masks=masks)
    table = masks.reshape(len(action), -1)
    assert table[np.arange(len(action)), action].all()

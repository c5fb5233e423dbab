"""Gymnasium's ids: for scenes of one's own, and of installed packages."""

import subprocess
import sys
from pathlib import Path

import pytest

from mot_sim.envs.registration import environment_id
from tests.mot_sim.own_things import write_own_things, write_package

ROOT = Path(__file__).parents[3]
PLAY = """
import gymnasium as gym, mot_sim
from mot_sim.envs.wrappers import TrackObservation

small = {"frames": 3, "houses": 0.0, "trees": 0.0, "furniture": 0.0}
env = gym.make("mot_sim/Scene-v0", scene="mine:my_scene", image=False, **small)
env = TrackObservation(env, "mine:forgetful")
assert env.reset(seed=1)[1]["frame"] == 0
assert "tracks" in env.step(0)[0]
env = gym.make(
    "mot_sim/Association-v0", scene="mine:my_scene", pool=1, tracker="mine:forgetful", **small
)
assert env.reset(seed=1)[0]["detections"].sum() > 0
both = gym.make_vec(
    "mot_sim/Scene-v0", num_envs=2, vectorization_mode="async", scene="mine:my_scene",
    image=False, **small,
)
assert both.reset(seed=1)[1]["frame"].tolist() == [0, 0]
both.close()
if "mot_sim/Overtaking-v0" in gym.registry:
    env = gym.make("mot_sim/Overtaking-v0", image=False, **small)
    assert env.unwrapped.scene.name == "overtaking"
    print("overtaking")
print(sum(name.startswith("mot_sim/") for name in gym.registry))
"""


@pytest.mark.parametrize("is_installed", [False, True])
def test_a_scene_of_ones_own_is_an_environment(tmp_path: Path, is_installed: bool) -> None:
    write_own_things(tmp_path)
    (tmp_path / "scenes.py").unlink()  # it would hide ours
    points = {"overtaking": "mine:my_scene", "crossing": "gone:x", "not well named": "gone:x"}
    if is_installed:
        write_package(tmp_path / "site", "theirs", {"mot_sim.scenes": points})
    (tmp_path / "play.py").write_text(PLAY)
    path = f"{ROOT}:{tmp_path / 'site'}"
    done = subprocess.run(
        [sys.executable, "play.py"], capture_output=True, text=True, check=False, timeout=300,
        cwd=tmp_path, env={"PYTHONPATH": path, "PATH": "", "MPLCONFIGDIR": str(tmp_path)},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == (["overtaking", "19"] if is_installed else ["18"])


@pytest.mark.parametrize("order", ["mot_sim, gymnasium", "gymnasium, mot_sim"])
def test_ids_are_registered_whichever_is_imported_first(order: str) -> None:
    code = f"""
import sys
before = list(sys.meta_path)
import {order}
assert "mot_sim/Crossing-v0" in gymnasium.registry
assert type(gymnasium.__loader__) is type(gymnasium.envs.__loader__)
assert gymnasium.__spec__.loader is gymnasium.__loader__
assert sys.meta_path == before, sys.meta_path
import mot_sim.envs.registration as again
again.register_with_gymnasium()
assert sys.meta_path == before
"""
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=60,
        env={"PYTHONPATH": str(ROOT), "PATH": ""},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


def test_an_id_is_the_name_in_capitals() -> None:
    assert environment_id("t_junction") == "mot_sim/TJunction-v0"

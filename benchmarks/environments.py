"""How fast the environments step: pixel-free over labels that are known, and many at once.

    python -m benchmarks.environments [--steps N]

Steps a second of one thread, by CPU and by wall time; machines differ and are shared. Every
figure is the best of three.
"""

import argparse
import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

from collections.abc import Callable  # noqa: E402
from time import perf_counter, process_time  # noqa: E402
from typing import Any  # noqa: E402

import gymnasium as gym  # noqa: E402
import numpy as np  # noqa: E402

import mot_sim  # noqa: E402, F401  (registers the ids)
from mot_sim.envs.association_experts import hungarian_policy  # noqa: E402
from mot_sim.envs.scene_env import SceneEnv, Scored, TrackObservation  # noqa: E402

ID = "mot_sim/Highway-v0"
CARS = 30
ROUNDS = 3


def options(frames: int) -> dict[str, Any]:
    """Thirty cars on three lanes, nothing drawn."""
    return {"frames": frames, "cars": CARS, "arrivals": 0.0, "image": False}


def play(env: gym.Env, policy: Callable[[Any], Any]) -> tuple[int, float, float]:
    """Steps, CPU and wall seconds of an episode whose labels are known, its reset left out."""
    observation, _ = env.reset(
        options={"episode_seed": 0} if env.spec.id == ID else {"episode_number": 0}
    )
    steps, ended, cpu, wall = 0, False, process_time(), perf_counter()
    while not ended:
        observation, _, terminated, truncated, _ = env.step(policy(observation))
        steps, ended = steps + 1, terminated or truncated
    return steps, process_time() - cpu, perf_counter() - wall


def report(name: str, env: gym.Env, policy: Callable[[Any], Any] = lambda _: 0) -> None:
    """Play once to find the labels, then for the record."""
    play(env, policy)
    rounds = [play(env, policy) for _ in range(ROUNDS)]
    by_cpu = max(steps / cpu for steps, cpu, _ in rounds)
    by_wall = max(steps / wall for steps, _, wall in rounds)
    print(f"{name:42} {by_cpu:8.0f} steps/s (CPU) {by_wall:8.0f} (wall)")


def report_live(frames: int) -> None:
    """Traffic, labels and detections made while stepping."""
    env = gym.make(ID, traffic="live", **options(frames))
    env.reset(seed=0)
    start = process_time()
    for _ in range(frames - 1):
        env.step(0)
    rate = (frames - 1) / (process_time() - start)
    print(f"{'live traffic, labels made on the way':42} {rate:8.1f} steps/s (CPU)")


def report_many(workers: int, steps: int, known: bool) -> float:
    """Steps a second of all workers together, by wall time.

    known: each plays one episode again and again; else every episode is a new one, and its
    traffic and labels are made on the way.
    """
    envs = gym.make_vec(ID, num_envs=workers, vectorization_mode="async", **options(steps + 1))
    nothing = np.zeros(workers, np.int64)
    envs.reset(seed=0, options={"episode_seed": 0} if known else None)
    best = 0.0
    for _ in range(ROUNDS + 1 if known else 1):
        start = perf_counter()
        envs.reset(options={"episode_seed": 0} if known else None)
        for _ in range(steps):
            envs.step(nothing)
        best = max(best, workers * steps / (perf_counter() - start))
    envs.close()
    name = f"async, {workers} worker(s), {'labels known' if known else 'new episodes'}"
    print(f"{name:42} {best:8.1f} steps/s (wall)")
    return best


def main() -> None:
    """Print all figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=100, help="of an episode")
    steps = parser.parse_args().steps
    env = gym.make(ID, **options(steps + 1))
    seen = [env.reset(options={"episode_seed": 0})[1]["truth"]]
    scene: SceneEnv = env.unwrapped  # type: ignore[assignment]
    seen += [env.step(0)[4]["truth"] for _ in range(steps)]
    present = np.mean([len(truth.world) for truth in seen])
    visible = np.mean([len(truth.exact) for truth in seen])
    print(f"{scene.scene.name}: {present:.1f} cars present, {visible:.1f} in the image, a frame")
    report("pixel-free, labels known", env)
    report("the same, tracked", TrackObservation(env))
    report("the same, tracked and scored", Scored(TrackObservation(env)))
    short = {"frames": steps + 1, "cars": CARS, "arrivals": 0.0, "scene": "highway", "pool": 1}
    report("Association-v0, Hungarian policy", gym.make("mot_sim/Association-v0", **short),
           hungarian_policy)  # fmt: skip
    report_live(min(steps, 30))
    for known in (True, False):
        one, two = (report_many(workers, steps, known) for workers in (1, 2))
        print(f"{'two workers against one':42} {two / one:8.2f} times")


if __name__ == "__main__":
    main()

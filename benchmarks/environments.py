"""How fast the environments step: pixel-free over labels that are known, and many at once.

    python -m benchmarks.environments [--steps N] [--update-baseline]
    python -m benchmarks.environments --worlds [--steps 5000] [--scenes highway,town]
    python -m benchmarks.environments --vector [--episodes 64]

Steps a second of one thread, by CPU and by wall time; machines differ and are shared. Every
figure is the best of three. The last part compares with highway-env's intersection, whose step is
1 s of traffic, in simulated seconds. --worlds: what becomes of long live runs under autopilot.
--vector: many episodes of association at once against one, by CPU, in turn.
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
from benchmarks.baseline import Ratios  # noqa: E402
from mot_sim.envs.association_experts import hungarian_policy  # noqa: E402
from mot_sim.envs.driving_tasks import META_ACTIONS  # noqa: E402
from mot_sim.envs.registration import environment_id  # noqa: E402
from mot_sim.envs.rollouts import driver_of  # noqa: E402
from mot_sim.envs.scene_env import SceneEnv, Scored, TrackObservation  # noqa: E402
from mot_sim.simulation.registry import SCENES, find_scene  # noqa: E402
from mot_sim.simulation.traffic.traffic_state import STEP_SECONDS  # noqa: E402
from tracker.errors import BadConfig  # noqa: E402

ID = "mot_sim/Highway-v0"
CARS = 30
ROUNDS = 3
STEPS_COMPARED = 20
POOL = 8  # episodes that are recorded for --vector
STANDING_REWARD = 0.01  # of the speed limit


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
        env.step(META_ACTIONS.index("autopilot"))
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


def report_resets() -> None:
    """What the reset to an episode that is new costs, in steps of the same episode."""
    for name in ("mot_sim/Crossing-v0", ID):
        for traffic in ("recorded", "live"):
            if traffic == "live" and name != ID:
                continue
            env = gym.make(name, image=False, frames=60, traffic=traffic)
            env.reset(seed=0)
            costs = []
            for seed in range(1, 1 + ROUNDS):
                start = process_time()
                env.reset(seed=seed)
                reset, start = process_time() - start, process_time()
                for _ in range(STEPS_COMPARED):
                    env.step(env.action_space.n - 1)
                costs.append(reset * STEPS_COMPARED / (process_time() - start))
            print(f"{name + ', ' + traffic + ': a new reset':42} {min(costs):8.1f} steps")


def simulated_seconds(env: gym.Env, idle: Any, seconds: float, steps: int) -> float:
    """Simulated seconds per CPU second; seconds: of one step."""
    env.reset(seed=0)
    start = process_time()
    for _ in range(steps):
        _, _, terminated, truncated, _ = env.step(idle)
        if terminated or truncated:
            env.reset()
    return steps * seconds / (process_time() - start)


def report_beside_highway_env(ratios: Ratios) -> None:
    """Driving at an intersection, resets included, as highway-env does it and as we do."""
    import highway_env  # noqa: F401  (registers its ids)

    theirs = simulated_seconds(gym.make("intersection-v1"), np.zeros(2, np.float32), 1.0, 40)
    options = {"actions": "meta", "frames": 130}
    autopilot = META_ACTIONS.index("autopilot")
    print(f"{'highway-env intersection-v1':42} {theirs:8.2f} simulated s per CPU s")
    for seen in ("kinematics", "detections"):
        env = gym.make("mot_sim/Intersection-v0", observation=seen, image=False, **options)
        ours = simulated_seconds(env, autopilot, STEP_SECONDS, 100)
        ratios.add(f"Intersection-v0, {seen}", 1.0 / ours, 1.0 / theirs)
        print(f"{'mot_sim/Intersection-v0, ' + seen:42} {ours:8.2f} simulated s per CPU s")


def report_worlds(scenes: list[str], steps: int) -> None:
    """Long runs of live traffic under autopilot: rewards, ends, and how long the ego car stood."""
    print(f"{'scene':28}  steps  reward last 1000  stood s new ways end")
    for name in scenes:
        env = gym.make(
            environment_id(name), continuous=True, observation="kinematics", frames=steps + 1
        )
        env.reset(options={"episode_seed": 0})
        rewards: list[float] = []
        stood = longest = 0
        end = "none"
        for _ in range(steps):
            _, reward, terminated, truncated, _ = env.step(META_ACTIONS.index("autopilot"))
            rewards.append(float(reward))
            stood = stood + 1 if reward <= STANDING_REWARD else 0
            longest = max(longest, stood)
            if terminated or truncated:
                end = "crash" if terminated else "last frame" if len(rewards) == steps else "road"
                break
        ways = env.unwrapped._rollout.driver.ego_ways
        print(
            f"{name:28} {len(rewards):6d} {np.mean(rewards):7.3f} {np.mean(rewards[-1000:]):9.3f} "
            f"{longest * STEP_SECONDS:8.1f} {ways:8d} {end}",
            flush=True,
        )


def report_vector(episodes: int) -> None:
    """Steps per CPU second of many episodes at once and of one, the same actions in both."""
    one = gym.make("mot_sim/Association-v0", pool=POOL).unwrapped
    envs = gym.make_vec("mot_sim/Association-v0", num_envs=episodes, pool=POOL)
    envs.unwrapped.one.source = one.source  # type: ignore[attr-defined]
    played = []
    for number in range(POOL):
        observation, _ = one.reset(options={"episode_number": number})
        actions, over = [], False
        while not over:
            actions.append(hungarian_policy(observation))
            observation, _, over, _, _ = one.step(actions[-1])
        played.append(actions)
    numbers, shortest = np.arange(episodes) % POOL, min(map(len, played))
    together = [np.stack([played[n][step] for n in numbers]) for step in range(shortest)]
    alone, at_once = [], []
    for _ in range(ROUNDS + 1):  # the first one loads the episodes
        seconds = 0.0
        for number, actions in enumerate(played):
            one.reset(options={"episode_number": number})
            started = process_time()
            for action in actions:
                one.step(action)
            seconds += process_time() - started
        alone.append(sum(map(len, played)) / seconds)
        envs.reset(seed=0, options={"episode_number": numbers})
        started = process_time()
        for action in together:
            envs.step(action)
        at_once.append(shortest * episodes / (process_time() - started))
    print(f"{'Association-v0, one episode':42} {max(alone[1:]):8.0f} steps/CPU s")
    print(f"{f'{episodes} episodes at once':42} {max(at_once[1:]):8.0f} steps/CPU s")
    print(f"{'episodes at once against one':42} {max(at_once[1:]) / max(alone[1:]):8.2f} times")


def live_scenes() -> list[str]:
    """The scenes that can be driven in."""
    found = []
    for name in SCENES:
        try:
            driver_of(find_scene(name), 0)
        except BadConfig:
            continue
        found.append(name)
    return found


def main() -> None:
    """Print all figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=100, help="of an episode")
    parser.add_argument("--worlds", action="store_true", help="long live runs instead")
    parser.add_argument("--scenes", help="of --worlds, by commas; default: all that are live")
    parser.add_argument("--vector", action="store_true", help="many episodes at once instead")
    parser.add_argument("--episodes", type=int, default=64, help="of --vector")
    Ratios.add_option(parser)
    given = parser.parse_args()
    steps = given.steps
    if given.vector:
        report_vector(given.episodes)
        return
    if given.worlds:
        report_worlds(given.scenes.split(",") if given.scenes else live_scenes(), steps)
        return
    env = gym.make(ID, **options(steps + 1))
    seen = [env.reset(options={"episode_seed": 0})[1]["truth"]]
    scene: SceneEnv = env.unwrapped  # type: ignore[assignment]
    seen += [env.step(0)[4]["truth"] for _ in range(steps)]
    present = np.mean([len(truth.traffic_state) for truth in seen])
    visible = np.mean([len(truth.exact) for truth in seen])
    print(f"{scene.scene.name}: {present:.1f} cars present, {visible:.1f} in the image, a frame")
    report("pixel-free, labels known", env)
    report("the same, tracked", TrackObservation(env))
    report("the same, tracked and scored", Scored(TrackObservation(env)))
    short = {"frames": steps + 1, "cars": CARS, "arrivals": 0.0, "scene": "highway", "pool": 1}
    report("Association-v0, Hungarian policy", gym.make("mot_sim/Association-v0", **short),
           hungarian_policy)  # fmt: skip
    report_live(min(steps, 30))
    report_resets()
    ratios = Ratios("environments")
    report_beside_highway_env(ratios)
    for known in (True, False):
        one, two = (report_many(workers, steps, known) for workers in (1, 2))
        print(f"{'two workers against one':42} {two / one:8.2f} times")
    ratios.tell(given.update_baseline)


if __name__ == "__main__":
    main()

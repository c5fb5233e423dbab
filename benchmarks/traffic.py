"""How fast live and recorded traffic are, whether it moves for ever, and whether memory grows.

    python -m benchmarks.traffic [--steps 10000]
    python -m benchmarks.traffic --continuous 20000 [--scenes intersection,street] [--seeds 3]

--continuous: every scene of live traffic is driven for so many steps, our car on one new way after
the other. Printed for the last 1,000 steps: cars on the road, those that move, cars that came in;
over all steps: ways that our car began, cars that crashed, states that show cars in one another
that are not marked as crashed, MB of memory gained after the first tenth, steps a second. Ctrl-C
ends a run early; its row says after how many steps.

CPU seconds of one thread. Machines differ and are shared: beside every figure stands its ratio
to a yardstick of the same run, highway-env's own `highway-v0` road with the same number of cars
(`road.act()`, `road.step(1 / 20)`, two ticks a frame), so more than 1 is faster than that.
"""

import argparse
import os
import resource
import sys
import tempfile

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

from collections.abc import Callable  # noqa: E402
from pathlib import Path  # noqa: E402
from time import process_time  # noqa: E402

import numpy as np  # noqa: E402
from highway_env.road.road import Road, RoadNetwork  # noqa: E402
from highway_env.vehicle.behavior import IDMVehicle  # noqa: E402

from mot_sim.simulation.cars import VehicleSampler  # noqa: E402
from mot_sim.simulation.random_numbers import named_stream  # noqa: E402
from mot_sim.simulation.registry import SCENES, find_scene  # noqa: E402
from mot_sim.simulation.traffic import (  # noqa: E402
    RecordedTraffic,
    Replay,
    Traffic,
    collisions,
    record_traffic,
)
from mot_sim.simulation.traffic.highway import ROADS, HighwayTraffic  # noqa: E402

CARS, FRAMES = 30, 100
LAST_STEPS = 1000  # of a long run, over which traffic must still move
CHECKED_EACH = 10  # steps; who has crashed stands for 20 s


def highway_env_itself(cars: int) -> float:
    """Frames a second of highway-env's own road and drivers."""
    network = RoadNetwork.straight_road_network(4, speed_limit=30.0)
    road = Road(network, np_random=np.random.RandomState(0))
    road.vehicles = [IDMVehicle.create_random(road, spacing=1.0) for _ in range(cars + 1)]
    start = process_time()
    for _ in range(FRAMES // 2):
        for _ in range(2):
            road.act()
            road.step(1 / 20)
    return FRAMES // 2 / (process_time() - start)


def frames_a_second(traffic: Traffic, frames: int) -> tuple[float, float]:
    """Speed after `reset`, and how many cars drove on the average."""
    traffic.reset(np.random.default_rng(0))
    driving = 0
    start = process_time()
    for _ in range(frames):
        driving += int((traffic.step().speed > 0.0).sum())
    return frames / (process_time() - start), driving / frames


def memory() -> float:
    """Resident MB now."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 1e6


def speed_table(row: Callable[[str, float, float], None]) -> None:
    """Live traffic on every road, then its replay."""
    for road in ROADS:
        live = HighwayTraffic(road, cars=CARS, arrivals=1.0, crashes="label")
        row(f"live, {road}", *frames_a_second(live, FRAMES))
    live = HighwayTraffic("intersection", cars=CARS, arrivals=1.0, crashes="label")
    recorded = record_traffic(live, np.random.default_rng(0), FRAMES / 10)
    row("replay, intersection", *frames_a_second(Replay(recorded), FRAMES))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "traffic.npz"
        recorded.save(path)
        size, start = path.stat().st_size, process_time()
        RecordedTraffic.load(path)
        print(f"file of {FRAMES / 10:.0f} s: {size / 1e3:.0f} kB, read in "
              f"{1e3 * (process_time() - start):.0f} ms")  # fmt: skip


def growth_table(steps: int) -> None:
    """Resident memory over many steps of live traffic in which cars come and go."""
    traffic = HighwayTraffic("roundabout", cars=12, arrivals=0.5, crashes="label")
    traffic.reset(np.random.default_rng(0))
    print("\nsteps    MB    cars driving")
    for step in range(1, steps + 1):
        world = traffic.step()
        if step % max(steps // 10, 1) == 0:
            print(f"{step:6d}{memory():7.1f}{int((world.speed > 0.0).sum()):8d}", flush=True)


def live_scenes() -> list[str]:
    """The scenes whose traffic is driven live."""
    return [
        name for name in SCENES
        if isinstance(find_scene(name).make_traffic(VehicleSampler().models_of(0)), HighwayTraffic)
    ]  # fmt: skip


def continuous_table(names: list[str], seeds: int, steps: int) -> None:
    """Long runs: whether traffic moves at their ends."""
    titles = ("steps", "driving", "moving", "came", "ways", "crashed", "unmarked", "MB", "steps/s")
    print(f"{'scene':14}{'seed':>5}" + "".join(f"{title:>9}" for title in titles), flush=True)
    for name in names:
        for seed in range(seeds):
            values = continuous_run(name, seed, steps)
            print(f"{name:14}{seed:5d}" + "".join(f"{each:9.1f}" for each in values), flush=True)


def continuous_run(name: str, seed: int, steps: int) -> tuple[float, ...]:
    """The figures of one long run, in the order of the table."""
    scene = find_scene(name)
    traffic = scene.make_traffic(scene.vehicle_sampler.models_of(seed))
    assert isinstance(traffic, HighwayTraffic)
    traffic.continuous = True
    parked = int((traffic.reset_live(named_stream(seed, "traffic")).speed == 0.0).sum())
    counts: list[tuple[int, int, int]] = []  # after each step: driving, moving, highest number
    crashed: set[int] = set()
    unmarked, base, start = 0, 0.0, process_time()
    try:
        for step in range(1, steps + 1):
            state = traffic.step()
            assert state.crashed is not None
            counts.append(
                (len(state) - parked, int((state.speed > 0.5).sum()), int(state.ids.max(initial=0)))
            )
            crashed |= set(state.ids[state.crashed].tolist())
            if step % CHECKED_EACH == 0:
                touching = np.setdiff1d(collisions(state), state.ids[state.crashed])
                unmarked += bool(len(touching[touching >= 0]))
            if step == max(steps // 10, 1):
                base = memory()
            if step % LAST_STEPS == 0:
                moving = np.mean(counts[-LAST_STEPS:], axis=0)[1]
                print(f"{name}, seed {seed}: {step} steps, {moving:.1f} cars move",
                      file=sys.stderr, flush=True)  # fmt: skip
    except KeyboardInterrupt:
        print(f"{name}, seed {seed}: ended after {len(counts)} steps", file=sys.stderr)
        if not counts:
            raise
    speed = len(counts) / (process_time() - start)
    numbers = np.maximum.accumulate([number for _, _, number in counts])
    came = numbers[-1] - numbers[-min(LAST_STEPS + 1, len(counts))]
    driving, moving, _ = np.mean(counts[-LAST_STEPS:], axis=0)
    grown = memory() - base if base else float("nan")
    return (
        len(counts), driving, moving, came, traffic.ego_ways, len(crashed), unmarked, grown, speed,
    )  # fmt: skip


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=10_000, help="of the memory table; 0: none")
    parser.add_argument("--continuous", type=int, help="steps of long runs; nothing else is run")
    parser.add_argument("--scenes", help="of the long runs; all of live traffic")
    parser.add_argument("--seeds", type=int, default=3, help="of the long runs")
    arguments = parser.parse_args()
    if arguments.continuous:
        names = arguments.scenes.split(",") if arguments.scenes else live_scenes()
        continuous_table(names, arguments.seeds, arguments.continuous)
        return
    steps = arguments.steps
    base = highway_env_itself(CARS)
    print(f"{CARS} cars              frames/s   driving   x yardstick")
    print(f"{'highway-env itself':22s}{base:8.0f}{CARS:10.1f}{1.0:14.2f}", flush=True)

    def row(name: str, speed: float, driving: float) -> None:
        print(f"{name:22s}{speed:8.0f}{driving:10.1f}{speed / base:14.2f}", flush=True)

    speed_table(row)
    if steps:
        growth_table(steps)


if __name__ == "__main__":
    main()

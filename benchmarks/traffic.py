"""How fast live and recorded traffic are, and whether 10,000 steps grow the memory.

    python -m benchmarks.traffic [--steps 10000]

CPU seconds of one thread. Machines differ and are shared: beside every figure stands its ratio
to a yardstick of the same run, highway-env's own `highway-v0` road with the same number of cars
(`road.act()`, `road.step(1 / 20)`, two ticks a frame), so more than 1 is faster than that.
"""

import argparse
import os
import resource
import tempfile

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

from collections.abc import Callable  # noqa: E402
from pathlib import Path  # noqa: E402
from time import process_time  # noqa: E402

import numpy as np  # noqa: E402
from highway_env.road.road import Road, RoadNetwork  # noqa: E402
from highway_env.vehicle.behavior import IDMVehicle  # noqa: E402

from mot_sim.simulation.traffic import RecordedTraffic, Replay, Traffic, record_traffic  # noqa: E402
from mot_sim.simulation.traffic.highway import ROADS, HighwayTraffic  # noqa: E402

CARS, FRAMES = 30, 100


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


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=10_000, help="of the memory table; 0: none")
    steps = parser.parse_args().steps
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

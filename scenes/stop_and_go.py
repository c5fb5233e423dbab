"""Stop-and-go on three lanes: waves of standing and driving run backwards through the columns."""

import numpy as np

from mot_sim.simulation.cars import Models, VehicleSampler
from mot_sim.simulation.scene import Scene
from mot_sim.simulation.traffic import Improvised, Roads, Route, Script, Scripted
from mot_sim.simulation.traffic.roads import rectangle, stripe
from tracker.errors import BadConfig

LANE_METRES = 3.5  # metres
LANES_Y = (-LANE_METRES, 0.0, LANE_METRES)  # y; the middle one is ours
COLUMN_ENDS_METRES = (-25.0, 95.0)  # metres behind and before us that cars stand in
ROUTE_END_X = 1500.0
REACTION_SECONDS = 0.45  # seconds from one car's change of speed to the next one's behind
KNOT_SECONDS = 0.5  # seconds between the points of a speed table


def stop_and_go(
    *,
    speed: float = 6.0,
    period: float = 14.0,
    gap: float = 4.0,
    alike: float = 0.0,
    frames: int = 200,
) -> Scene:
    """Three columns of cars that stop and go.

    speed: m/s between two stops, 1 to 15.
    period: seconds from one stop to the next, 6 to 60.
    gap: metres between standing cars, 3 to 30.
    alike: share of the car models that look the same, 0 to 1.
    frames: length of the run in frames, at 10 Hz.
    """
    if not 1.0 <= speed <= 15.0 or not 6.0 <= period <= 60.0:
        raise BadConfig(
            f"speed {speed:g} m/s and period {period:g} s of stop-and-go: give 1 to 15, and 6 to 60"
        )
    if not 3.0 <= gap <= 30.0:
        raise BadConfig(f"gap of stop-and-go is {gap:g}: give 3 to 30 metres")

    def traffic(models: Models) -> Improvised:
        return Improvised(lambda rng: _script(rng, models, speed, period, gap, 0.1 * frames))

    return Scene(
        "stop_and_go", traffic, frames, _roads(), vehicle_sampler=VehicleSampler(alike=alike)
    )


def _script(
    rng: np.random.Generator,
    models: Models,
    speed: float,
    period: float,
    gap: float,
    seconds: float,
) -> Scripted:
    """The columns; every lane has its own phase and pace of the wave."""
    cars, ego = [], None
    for y in LANES_Y:
        pace, phase = speed * rng.uniform(0.8, 1.0), rng.uniform(0.0, period)
        # A car that reacts later has come closer by at most so much.
        closer = pace * REACTION_SECONDS
        x = COLUMN_ENDS_METRES[1] + rng.uniform(0.0, 5.0)
        number = 0
        while x > COLUMN_ENDS_METRES[0]:
            size = models.size[rng.integers(len(models.size))]
            length, height, width = (float(value) for value in size)
            x -= 0.5 * length
            table = _waves(pace, period, phase + number * REACTION_SECONDS, seconds)
            script = Script(Route([(x, y), (ROUTE_END_X, y)]), table, size=(length, height, width))
            is_ours = y == 0.0 and ego is None and x < 0.0
            if is_ours:
                ego = script
            else:
                cars.append(script)
            x -= 0.5 * length + gap + closer + rng.exponential(1.5)
            number += 1
    assert ego is not None
    return Scripted(cars, ego)


def _waves(pace: float, period: float, delay: float, seconds: float) -> list[tuple[float, float]]:
    """A speed table: a quarter of the period at rest, then up to the pace and down again."""
    times = np.arange(0.0, seconds + KNOT_SECONDS, KNOT_SECONDS)
    turn = np.mod((times - delay) / period, 1.0)
    speeds = pace * np.clip(1.5 * np.sin(np.pi * np.clip((turn - 0.25) / 0.75, 0.0, 1.0)), 0.0, 1.0)
    return list(zip(times.tolist(), speeds.tolist(), strict=True))


def _roads() -> Roads:
    """Three lanes one way, with shoulders."""
    x, edge = (-80.0, 700.0), 1.5 * LANE_METRES
    surfaces = [rectangle("asphalt", x, (-edge - 2.5, edge + 2.5))]
    for y in (-0.5 * LANE_METRES, 0.5 * LANE_METRES):
        surfaces += stripe((x[0], y), (x[1], y), dash=(4.0, 6.0))
    for y in (-edge, edge):
        surfaces += stripe((x[0], y), (x[1], y), 0.2)
    return Roads(tuple(surfaces))

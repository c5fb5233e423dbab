"""Traffic recorded once into arrays, kept in one file, and replayed many times."""

from collections.abc import Iterable
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped, jaxtyped
from numpy import ndarray as Array

from mot_sim.files.array_files import ArrayFormat, checksum, require_columns
from mot_sim.simulation.traffic.traffic_state import STEP_SECONDS, Traffic, TrafficState
from tracker.errors import BadConfig, BadFile

TRAFFIC_FORMAT = ArrayFormat("recorded traffic", 1)
STILL_SPEED = 0.05  # m/s, below which a car that is first seen is parked
OPTIONAL_COLUMNS = {"z", "crashed", "kinds", "tilt"}


@dataclass(frozen=True, eq=False)
class RecordedTraffic:
    """Who was where, every 0.1 s: rows are states, columns are cars, in the frame of
    `TrafficState`."""

    start: Float[Array, ""]
    """Time of the first state, seconds."""
    ids: Int[Array, " n"]
    """Id of the car in each column, increasing."""
    present: Bool[Array, "t n"]
    """Whether a car is there in a state; where it is not, its other values are NaN."""
    x: Float[Array, "t n"]
    """Centre in world, metres."""
    y: Float[Array, "t n"]
    """Centre in world, metres."""
    heading: Float[Array, "t n"]
    """Radians from world +x towards +y."""
    speed: Float[Array, "t n"]
    """Along the heading, m/s."""
    size: Float[Array, "t n 3"]
    """Length, height, width, metres."""
    ego: Float[Array, "t 3"]
    """x, y (metres) and heading (radians) in world of the car that carries the camera."""
    ego_size: Float[Array, "t 3"]
    """Length, height, width of that car, metres."""
    z: Float[Array, "t n"] | None = None
    """Bottom face, metres down from the ground; None: all cars stand on it."""
    crashed: Bool[Array, "t n"] | None = None
    """Whether a car has hit another by then; None: crashes were not followed."""
    kinds: Shaped[Array, " n"] | None = None
    """KITTI's class of the car in each column, 'Car' or 'Van'; None or '': by its shape."""
    tilt: Float[Array, "t 2"] | None = None
    """Pitch and roll of the body of the car that carries the camera, radians; None: it stays
    level."""

    def __len__(self) -> int:
        return len(self.present)

    def until(self, count: int) -> "RecordedTraffic":
        """The first states of it, and only the cars of those; at least one."""
        return RecordedTraffic.of(self.state(index) for index in range(min(count, len(self))))

    def state(self, index: int) -> TrafficState:
        """The state of a row; the same bits that were recorded."""
        there = self.present[index]
        return TrafficState(
            time=float(self.start) + index * STEP_SECONDS,
            ids=self.ids[there],
            x=self.x[index, there],
            y=self.y[index, there],
            heading=self.heading[index, there],
            speed=self.speed[index, there],
            size=self.size[index, there],
            ego=self.ego[index].copy(),
            ego_size=self.ego_size[index].copy(),
            z=None if self.z is None else self.z[index, there],
            crashed=None if self.crashed is None else self.crashed[index, there],
            kinds=None if self.kinds is None else self.kinds[there],
            tilt=None if self.tilt is None else self.tilt[index].copy(),
        )

    @property
    def states(self) -> tuple[TrafficState, ...]:
        """All states."""
        return tuple(self.state(index) for index in range(len(self)))

    @property
    def parked_ids(self) -> Int[Array, " k"]:
        """The cars that stand when they are first there: nobody sits in them."""
        first = self.present.argmax(axis=0)
        speed = np.abs(self.speed[first, np.arange(len(self.ids))])
        return self.ids[speed < STILL_SPEED]

    @property
    def checksum(self) -> str:
        """SHA-256 of all arrays: names, types, shapes and bytes, in the order of fields."""
        return checksum(self.arrays())

    def arrays(self) -> dict[str, Any]:
        """The fields that are not None."""
        named = {column.name: getattr(self, column.name) for column in fields(self)}
        return {name: array for name, array in named.items() if array is not None}

    @classmethod
    def of(cls, states: Iterable[TrafficState]) -> "RecordedTraffic":
        """The recording of states, 0.1 s apart. Raises BadConfig for rows not in order of ids."""
        states = list(states)
        if not states:
            raise BadConfig("a recording of no states: give one or more")
        ids = np.unique(np.concatenate([state.ids for state in states]))
        shape = len(states), len(ids)
        columns = {name: np.full(shape, np.nan) for name in ("x", "y", "heading", "speed", "z")}
        size = np.full((*shape, 3), np.nan)
        present, crashed = np.zeros(shape, bool), np.zeros(shape, bool)
        kinds = np.zeros(len(ids), "<U16")
        for row, state in enumerate(states):
            if (np.diff(state.ids) <= 0).any():
                raise BadConfig(f"state {row}: ids {state.ids.tolist()} do not increase")
            at = np.searchsorted(ids, state.ids)
            present[row, at] = True
            size[row, at] = state.size
            for name, column in columns.items():
                column[row, at] = 0.0 if getattr(state, name) is None else getattr(state, name)
            crashed[row, at] = False if state.crashed is None else state.crashed
            kinds[at] = "" if state.kinds is None else state.kinds
        if all(state.z is None for state in states):
            del columns["z"]
        tilts = [np.zeros(2) if state.tilt is None else state.tilt for state in states]
        return cls(
            start=np.array(states[0].time),
            ids=ids,
            present=present,
            size=size,
            ego=np.array([state.ego for state in states]),
            ego_size=np.array([state.ego_size for state in states]),
            crashed=None if all(state.crashed is None for state in states) else crashed,
            kinds=None if all(state.kinds is None for state in states) else kinds,
            tilt=None if all(state.tilt is None for state in states) else np.array(tilts),
            **columns,
        )

    def save(self, path: Path) -> None:
        """Write the arrays, their checksum and the version, as a whole or not at all.

        The same recording gives the same bytes. Raises BadOutput.
        """
        TRAFFIC_FORMAT.write(path, self.arrays())

    @classmethod
    def load(cls, path: Path) -> "RecordedTraffic":
        """Read what `save` wrote. Raises BadFile for any other file, naming it."""
        names = {column.name for column in fields(cls)}
        arrays = TRAFFIC_FORMAT.read(path, names - OPTIONAL_COLUMNS, OPTIONAL_COLUMNS)
        with jaxtyped("context"):
            require_columns(cls, {name: arrays.get(name) for name in names}, f"{path}: ")
        if not len(arrays["present"]):
            raise BadFile(f"{path}: traffic of no states; record again")
        return cls(**arrays)


def record_traffic(traffic: Traffic, rng: np.random.Generator, seconds: float) -> RecordedTraffic:
    """The states of some seconds, the first and the last included."""
    if not 0.0 <= seconds < np.inf:
        raise BadConfig(f"record {seconds:g} s of traffic: give 0 or more")
    states = [traffic.reset(rng)]
    states += [traffic.step() for _ in range(round(seconds / STEP_SECONDS))]
    return RecordedTraffic.of(states)


@dataclass(eq=False)
class Replay:
    """Traffic that does what was recorded, whatever the seed."""

    recording: RecordedTraffic
    """What the cars do."""
    index: int = field(default=0, init=False)
    """Row of the recording that was given last."""

    def reset(self, rng: np.random.Generator) -> TrafficState:
        """The first state; nothing is drawn from the generator."""
        self.index = 0
        return self.recording.state(0)

    def step(self) -> TrafficState:
        """The next state. Raises BadConfig after the last one."""
        if self.index + 1 >= len(self.recording):
            raise BadConfig(
                f"the recorded traffic ends after {len(self.recording)} states: record a longer one"
            )
        self.index += 1
        return self.recording.state(self.index)

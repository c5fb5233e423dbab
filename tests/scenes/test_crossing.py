"""The scripted crossing holds what its docstring says, and nobody touches anybody."""

import numpy as np
import pytest

from mot_sim.simulation.episode import Episode, record
from mot_sim.simulation.registry import find_scene
from tracker.geometry import convex_intersection, wrap_angle


@pytest.fixture(scope="module")
def episode() -> Episode:
    return record(find_scene("crossing"))


def paths(episode: Episode) -> dict[int, np.ndarray]:
    """By car: rows (frame, x, y, heading, speed)."""
    rows = [
        (track_id, frame, *values)
        for frame, state in enumerate(episode.traffic_states)
        for track_id, *values in zip(
            state.ids, state.x, state.y, state.heading, state.speed, strict=True
        )
    ]
    table = np.array(rows)
    return {int(car): table[table[:, 0] == car, 1:] for car in np.unique(table[:, 0])}


def test_it_lasts_twelve_to_fifteen_seconds_with_six_to_ten_cars(episode) -> None:
    assert 120 <= len(episode) <= 150
    assert 6 <= len(np.unique(episode.exact.tracks.ids)) <= 10


def test_nobody_drives_through_anybody(episode) -> None:
    for state in episode.traffic_states:
        outlines = np.concatenate((state.footprint(), state.ego_footprint()[None]))
        first, second = np.triu_indices(len(outlines), 1)
        assert convex_intersection(outlines[first], outlines[second]).max() == 0.0, state.time


def test_nobody_jumps_brakes_or_turns_harder_than_a_car_can(episode) -> None:
    for path in paths(episode).values():
        assert (np.diff(path[:, 0]) == 1).all()
        moved = np.hypot(*np.diff(path[:, 1:3], axis=0).T)
        np.testing.assert_allclose(moved, 0.1 * path[1:, 4], atol=0.05)
        assert np.abs(np.diff(path[:, 4]) / 0.1).max() < 3.0
        turning = np.abs(wrap_angle(np.diff(path[:, 3]))) / 0.1
        assert (turning * path[1:, 4]).max() < 8.0


def test_cars_cross_from_both_sides_and_one_oncoming_turns_left_before_us(episode) -> None:
    ends = {car: (path[0], path[-1]) for car, path in paths(episode).items()}
    crossing = {
        car: np.sign(last[2] - first[2])
        for car, (first, last) in ends.items()
        if abs(last[2] - first[2]) > 30 and abs(last[1] - first[1]) < 1
    }
    assert sorted(crossing.values()).count(1.0) >= 2
    assert sorted(crossing.values()).count(-1.0) >= 2
    turning = [
        car
        for car, (first, last) in ends.items()
        if abs(first[3]) == pytest.approx(np.pi) and np.sin(last[3]) == pytest.approx(1.0)
    ]
    assert len(turning) == 1


def test_one_car_is_lost_behind_another_for_more_than_a_second_and_comes_back(episode) -> None:
    exact = episode.exact
    found = False
    for car in np.unique(exact.tracks.ids):
        visible = exact.visible[exact.tracks.ids == car]
        hidden = visible < 0.2
        edges = np.flatnonzero(np.diff(np.concatenate(([0], hidden.astype(int), [0]))))
        for start, end in edges.reshape(-1, 2):
            before, after = visible[:start], visible[end:]
            found |= end - start > 10 and (before > 0.6).any() and (after > 0.8).any()
    assert found


def test_we_stop_before_the_junction_and_then_drive_on(episode) -> None:
    x = np.array([state.ego[0] for state in episode.traffic_states])
    steps = np.diff(x)
    standing = np.flatnonzero(steps < 1e-6)
    assert len(standing) > 20
    assert x[standing[0]] < 40.0
    assert x[-1] > x[standing[0]] + 5.0


def test_one_car_leads_us_all_the_way(episode) -> None:
    lead = paths(episode)[0]
    ego = np.array([state.ego for state in episode.traffic_states])
    gap = lead[:, 1] - ego[:, 0]
    assert len(lead) == len(episode)
    assert (gap > 5.0).all()
    assert (np.abs(lead[:, 2] - ego[:, 1]) < 0.5).all()

"""The states beside a file of results."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mot_sim.datasets.boxes import box_files
from mot_sim.datasets.estimate_files import COLUMNS, estimates_path, read_estimates
from mot_sim.datasets.kitti.labels import read_results, write_results
from tracker.errors import BadFile, BadOutput, BadTracks
from tracker.types import Camera, CarEstimates, Tracks

K = np.array([[100.0, 0, 50], [0, 100, 20], [0, 0, 1]])
T_ROAD_LABEL = Camera.mounted(K, (100, 40), 1.65, pitch=0.02).T_road_cam


def some_tracks(seed: int = 0, count: int = 3, size: float = 0.1) -> Tracks:
    """Cars with states whose deviations differ by orders of magnitude."""
    rng = np.random.default_rng(seed)
    means = rng.normal([0.0, 0.0, 30.0, 0.0, 5.0, 1.4, 0.4, 0.5, 0.0], size, (count, 9))
    turns, _ = np.linalg.qr(rng.normal(size=(count, 9, 9)))
    roots = turns * (10.0 ** rng.uniform(-2.0, 1.0, (count, 1, 9)))
    covs = roots @ roots.transpose(0, 2, 1)
    states = CarEstimates(means, 0.5 * (covs + covs.transpose(0, 2, 1)), rng.uniform(0.5, 1, count))
    frames, boxes = np.arange(count) // 2, np.tile([1.0, 2.0, 30.0, 20.0], (count, 1))
    return Tracks(frames, np.arange(count), boxes, cuboids=states.cuboids(), estimates=states)


def written_states(folder: Path) -> Path:
    """The file of states beside results of some tracks."""
    path = folder / "0000.txt"
    write_results(some_tracks(), path, T_ROAD_LABEL)
    return estimates_path(path)


@settings(max_examples=25)
@given(st.integers(0, 1000), st.floats(0.0, 1.0))
def test_states_are_read_back_as_they_were_written(
    tmp_path_factory: pytest.TempPathFactory, seed: int, size: float
) -> None:
    tracks = some_tracks(seed, size=size)
    path = tmp_path_factory.mktemp("states") / "0000.txt"
    write_results(tracks, path, T_ROAD_LABEL)
    found, given_states = read_results(path, T_ROAD_LABEL).estimates, tracks.estimates
    assert found is not None
    assert given_states is not None
    turn = np.exp(1j * found.means[:, 3]) - np.exp(1j * given_states.means[:, 3])
    np.testing.assert_allclose(turn, 0.0, atol=1e-7)
    others = [0, 1, 2, 4, 5, 6, 7, 8]
    np.testing.assert_allclose(found.means[:, others], given_states.means[:, others], rtol=1e-8,
                               atol=1e-8)  # fmt: skip
    scale = np.sqrt(np.einsum("nii->ni", given_states.covs))
    off = (found.covs - given_states.covs) / (scale[:, :, None] * scale[:, None, :])
    np.testing.assert_allclose(off, 0.0, atol=1e-5)
    np.testing.assert_allclose(found.heading_known, given_states.heading_known, rtol=1e-8)


def test_a_row_without_a_state_has_none_when_it_is_read_back(tmp_path: Path) -> None:
    tracks = some_tracks()
    states = CarEstimates.unknown(3).updated([0, 2], tracks.estimates.select([0, 2]))  # type: ignore[union-attr]
    path = tmp_path / "0000.txt"
    write_results(tracks.replaced(estimates=states), path, T_ROAD_LABEL)
    found = read_results(path, T_ROAD_LABEL).estimates
    assert found is not None
    assert np.isnan(found.means).all(axis=1).tolist() == [False, True, False]


def test_states_that_no_longer_belong_to_the_results_are_removed_or_named(tmp_path: Path) -> None:
    path, tracks = tmp_path / "0000.txt", some_tracks()
    write_results(tracks, path, T_ROAD_LABEL)
    old = estimates_path(path).read_text()
    write_results(some_tracks(1), path, T_ROAD_LABEL)
    estimates_path(path).write_text(old)
    with pytest.raises(BadFile, match=r"0000.estimates.csv: id 0 in frame 0 .* other results"):
        read_results(path, T_ROAD_LABEL)
    write_results(tracks.replaced(estimates=None), path, T_ROAD_LABEL)
    assert not estimates_path(path).exists()
    assert read_results(path, T_ROAD_LABEL).estimates is None


def test_a_place_that_cannot_be_written_to_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for tracks in (some_tracks(), some_tracks().replaced(estimates=None)):
        with pytest.raises(BadOutput, match=r"0000.estimates.csv: cannot be"):
            write_results(tracks, tmp_path / "file" / "0000.txt", T_ROAD_LABEL)


def test_states_that_are_known_in_part_are_refused(tmp_path: Path) -> None:
    tracks = some_tracks()
    assert tracks.estimates is not None
    tracks.estimates.means[1, 4] = np.nan
    with pytest.raises(BadTracks, match="id 1 in frame 0 is finite in part"):
        write_results(tracks, tmp_path / "0000.txt", T_ROAD_LABEL)


def test_a_folder_of_results_is_no_folder_of_twice_as_many_boxes(tmp_path: Path) -> None:
    write_results(some_tracks(), tmp_path / "0000.txt", T_ROAD_LABEL)
    assert list(box_files(tmp_path)) == ["0000"]


@pytest.mark.parametrize(
    ("column", "value", "message"),
    [
        ("x_m", "nan", ":3: x_m is not finite"),
        ("length_m", "0", ":3: a size that is not positive: length_m 0, .*metres above 0"),
        ("height_m", "1500", ":3: a size of no vehicle"),
        ("heading_known", "1.5", ":3: no probability: heading_known 1.5"),
        ("cov_yaw_yaw", "-1", ":3: no variance: cov_yaw_yaw -1"),
        ("cov_x_y", "1e6", ":3: a covariance that is not positive.*frame 0, id 1"),
        ("id", "0", ":3: an id twice in a frame: frame 0, id 0"),
        ("speed", "fast", ":3: speed is 'fast', which is no number"),
    ],
)
def test_bad_states_are_named_with_line_value_and_cure(
    tmp_path: Path, column: str, value: str, message: str
) -> None:
    beside = written_states(tmp_path)
    lines = beside.read_text().splitlines()
    fields = lines[2].split(",")
    fields[COLUMNS.index(column)] = value
    lines[2] = ",".join(fields)
    beside.write_text("\n".join(lines))
    with pytest.raises(BadFile, match=message):
        read_estimates(beside, T_ROAD_LABEL)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("cov_x_y", "cov_x_why", ":1: no column cov_x_y in"),
        ("frame,", "frame,id,", ":1: the column 'id' stands twice"),
        ("frame,", "frame,mood,", ":1: the column 'mood' is unknown"),
    ],
)
def test_columns_that_lack_or_are_strange_are_named(
    tmp_path: Path, old: str, new: str, message: str
) -> None:
    beside = written_states(tmp_path)
    beside.write_text(beside.read_text().replace(old, new, 1))
    with pytest.raises(BadFile, match=message):
        read_estimates(beside, T_ROAD_LABEL)


def test_yaws_beyond_pi_are_wrapped(tmp_path: Path) -> None:
    tracks = some_tracks(count=1)
    assert tracks.estimates is not None
    tracks.estimates.means[:, 3] = 4.0
    write_results(tracks, tmp_path / "0000.txt", T_ROAD_LABEL)
    _, _, states = read_estimates(tmp_path / "0000.estimates.csv", T_ROAD_LABEL)
    np.testing.assert_allclose(states.means[:, 3], 4.0 - 2.0 * np.pi)


def test_another_pitch_moves_states_and_cuboids_alike(tmp_path: Path) -> None:
    tracks, path = some_tracks(), tmp_path / "0000.txt"
    write_results(tracks, path, T_ROAD_LABEL)
    level = Camera.mounted(K, (100, 40), 1.65).T_road_cam
    found = read_results(path, level)
    assert found.estimates is not None
    assert found.cuboids is not None
    np.testing.assert_allclose(found.estimates.means[:, :3], found.cuboids.base, atol=1e-5)
    moved = found.estimates.covs[:, :3, :3]
    turn = (level @ np.linalg.inv(T_ROAD_LABEL))[:3, :3]
    assert tracks.estimates is not None
    np.testing.assert_allclose(moved, turn @ tracks.estimates.covs[:, :3, :3] @ turn.T, rtol=1e-6,
                               atol=1e-7)  # fmt: skip

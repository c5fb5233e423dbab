"""The shipped prior and the authors' text files, through one door."""

from pathlib import Path

import numpy as np
import pytest

from tracker.errors import BadFile, DatasetNotFound, UnknownName
from tracker.shape import KEYPOINTS, KEYPOINTS_14, KEYPOINTS_36, load_prior, save_prior
from tracker.shape.prior import turned_points


def write(path: Path, rows: np.ndarray) -> None:
    path.write_text("\n".join(" ".join(f"{value:.6f}" for value in row) for row in rows))


def authors_36(folder: Path) -> np.ndarray:
    """A folder in the authors' format, made up; gives its mean."""
    mean = np.random.default_rng(0).normal(size=(36, 3)).round(6)
    write(folder / "meanShape.txt", mean)
    write(folder / "basisVectors.txt", np.eye(4, 108))
    write(folder / "shapeCoefficientsInitial.txt", np.array([[0.04, 0.01, 0.0, 0.0]]))
    return mean


def test_the_shipped_prior_is_a_car_in_metres_on_the_road() -> None:
    basis = load_prior()
    assert basis.points == KEYPOINTS_36
    assert basis.std is not None
    assert basis.size == len(basis.std) == 20
    assert (np.diff(basis.std) < 0.0).all()
    spread = np.ptp(basis.mean, axis=0)
    assert (spread > (3.4, 0.9, 1.4)).all()
    assert (spread < (4.6, 1.5, 1.9)).all()
    assert basis.mean[:, 1].max() < 0.0  # y is down: everything is above the road
    rows = {name: basis.mean[row] for row, name in enumerate(basis.points)}
    assert rows["left_headlight"][0] > 1.5 > -1.5 > rows["left_taillight"][0]
    assert rows["left_roof_front"][2] > 0.0 > rows["right_roof_front"][2]


def test_rows_18_to_35_mirror_rows_0_to_17_in_every_shape() -> None:
    basis = load_prior()
    lambdas = np.random.default_rng(1).normal(size=(5, 20))
    shapes = basis.shape(lambdas)
    np.testing.assert_allclose(shapes[:, 18:], shapes[:, :18] * (1, 1, -1), atol=1e-12)


def test_the_fourteen_points_come_with_mirrors_and_the_same_coefficients() -> None:
    full, few = load_prior(points=KEYPOINTS), load_prior(points=KEYPOINTS_14)
    lambdas = np.random.default_rng(2).normal(size=20)
    rows = [KEYPOINTS.index(name) for name in KEYPOINTS_14]
    np.testing.assert_allclose(few.shape(lambdas), full.shape(lambdas)[rows], atol=1e-12)
    assert few.points[0] == "left_front_wheel"


def test_the_authors_36_points_turn_into_our_axes(tmp_path: Path) -> None:
    mean = authors_36(tmp_path)
    basis = load_prior(tmp_path)
    np.testing.assert_allclose(basis.mean, mean * (1, -1, -1))
    np.testing.assert_allclose(basis.std, (0.2, 0.1, 0.0, 0.0))
    assert basis.vectors[1, 0].tolist() == [0.0, -1.0, 0.0]  # their up is our minus down


def test_the_authors_14_points_turn_into_our_axes(tmp_path: Path) -> None:
    mean = np.zeros((14, 3))
    mean[0] = (1.0, -2.0, 0.5)  # left, backwards, up
    write(tmp_path / "meanShape14.txt", mean)
    write(tmp_path / "vectors14.txt", np.eye(5, 42))
    basis = load_prior(tmp_path)
    assert basis.points == KEYPOINTS_14
    assert basis.mean[0].tolist() == [2.0, -0.5, 1.0]  # forward, down, left
    assert basis.std is None


def test_a_prior_comes_back_from_its_file(tmp_path: Path) -> None:
    basis = load_prior(points=KEYPOINTS).first(3)
    save_prior(basis, tmp_path / "mine.npz")
    again = load_prior(tmp_path / "mine.npz", KEYPOINTS)
    np.testing.assert_array_equal(again.vectors, basis.vectors)
    np.testing.assert_array_equal(again.mean, basis.mean)
    np.testing.assert_array_equal(again.std, basis.std)


def test_a_prior_of_the_authors_comes_back_from_our_file(tmp_path: Path) -> None:
    authors_36(tmp_path)
    basis = load_prior(tmp_path)
    save_prior(basis, tmp_path / "theirs.npz")
    np.testing.assert_array_equal(load_prior(tmp_path / "theirs.npz").mean, basis.mean)


@pytest.mark.parametrize(
    ("file", "text", "told"),
    [
        ("meanShape.txt", "1 2 3\n1 two 3", r"meanShape.txt:2: could not convert"),
        ("meanShape.txt", "1 2 3\n1 2", r"meanShape.txt:2: 2 numbers, not 3 finite"),
        ("meanShape.txt", "1 2 nan", r"meanShape.txt:1: 3 numbers, not 3 finite"),
        ("meanShape.txt", "1 2 3", r"meanShape.txt: 1 points, not 36"),
        ("meanShape.txt", "", r"meanShape.txt is empty"),
        ("basisVectors.txt", "1 2 3", r"basisVectors.txt:1: 3 numbers, not 108"),
        ("shapeCoefficientsInitial.txt", "1 2", r"Initial.txt:1: 2 numbers, not 4"),
    ],
)
def test_a_broken_text_prior_names_file_and_line(
    tmp_path: Path, file: str, text: str, told: str
) -> None:
    authors_36(tmp_path)
    (tmp_path / file).write_text(text)
    with pytest.raises(BadFile, match=told):
        load_prior(tmp_path)


def test_what_is_not_there_or_no_prior_is_said(tmp_path: Path) -> None:
    with pytest.raises(DatasetNotFound, match=r"no shape prior at .*nowhere"):
        load_prior(tmp_path / "nowhere")
    with pytest.raises(DatasetNotFound, match=r"should hold meanShape.txt or meanShape14.txt"):
        load_prior(tmp_path)
    authors_36(tmp_path)
    (tmp_path / "basisVectors.txt").unlink()
    with pytest.raises(DatasetNotFound, match=r"lacks .*basisVectors.txt"):
        load_prior(tmp_path)
    (tmp_path / "bad.npz").write_bytes(b"PK no archive")
    with pytest.raises(BadFile, match=r"bad.npz is no shape prior"):
        load_prior(tmp_path / "bad.npz")
    with pytest.raises(UnknownName, match="unknown point 'left_nose'"):
        load_prior(points=["left_nose"])


def test_arrays_that_do_not_belong_together_are_refused(tmp_path: Path) -> None:
    np.savez(
        tmp_path / "odd.npz",
        points=np.array(["a"]), mean=np.zeros((2, 3)), vectors=np.zeros((1, 2, 3)), std=np.ones(1),
    )  # fmt: skip
    with pytest.raises(BadFile, match="do not belong together"):
        load_prior(tmp_path / "odd.npz")


def test_a_car_turned_round_has_a_point_where_each_of_its_points_was_about() -> None:
    rows = turned_points(KEYPOINTS_36)
    assert rows is not None
    assert sorted(rows) == list(range(36))
    assert [rows[row] for row in rows] == list(range(36))
    assert KEYPOINTS_36[rows[KEYPOINTS_36.index("left_taillight")]] == "right_headlight"
    mean = load_prior().mean
    turned = mean[rows] * [-1.0, 1.0, -1.0]
    assert np.abs(turned - mean)[:, 1:].max() < 0.25  # heights and sides; the roof is longer behind
    assert np.abs(turned - mean)[:, 0].max() < 1.1


def test_points_without_counterparts_of_the_other_end_are_told() -> None:
    assert turned_points(KEYPOINTS_14) is None
    assert turned_points(["a", "left_b"]) is None
    assert turned_points([]) == []

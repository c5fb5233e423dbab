"""`mot-sim export-car`."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from tests.mot_sim.cli.conftest import CommandLine


def test_a_drawn_car_is_written_and_described(mot_sim: CommandLine, tmp_path: Path) -> None:
    path = tmp_path / "car.glb"
    outcome = mot_sim("export-car", path, "--body", "van", "--paint", "red", "--seed", 4)
    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.out.startswith(f"{path}: ")
    assert ", red; coefficients " in outcome.out
    assert trimesh.load(path).extents[1] > 1.5  # glTF's y is up
    again = tmp_path / "again.glb"
    mot_sim("export-car", again, "--body", "van", "--paint", "red", "--seed", 4)
    assert again.read_bytes() == path.read_bytes()


def test_a_size_gives_a_car_of_about_that(mot_sim: CommandLine, tmp_path: Path) -> None:
    path = tmp_path / "car.glb"
    assert mot_sim("export-car", path, "--size", "4.4,1.5,1.8").code == 0
    np.testing.assert_allclose(trimesh.load(path).extents, [1.8, 1.5, 4.4], atol=0.03)


def test_coefficients_say_the_shape(mot_sim: CommandLine, tmp_path: Path) -> None:
    path = tmp_path / "car.glb"
    outcome = mot_sim("export-car", path, "--coefficients=-0.1,0.05,0.02")
    assert outcome.code == 0
    assert outcome.out.endswith("coefficients -0.1000,0.0500,0.0200\n")


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--coefficients", "0,99"], "shape coefficient 1 of car 0 is 99: the population reaches"),
        (["--coefficients", "a"], "--coefficients a: write numbers between commas"),
        (["--coefficients", ",".join(["0"] * 21)], "21 shape coefficients: give 1 to 20"),
        (["--coefficients", "nan"], "shape coefficient 0 of car 0 is nan"),
        (["--coefficients", "0", "--size", "4,1,2"], "--coefficients and --size both say"),
        (["--size", "4,1"], "--size 4,1: three numbers above 0"),
        (["--size", "4,-1,2"], "--size 4,-1,2: three numbers above 0"),
        (["--paint", "rad"], "unknown colour 'rad'"),
        (["--body", "bus"], "unknown body 'bus'"),
    ],
)
def test_wrong_input_is_one_line(
    mot_sim: CommandLine, tmp_path: Path, arguments: list[str], told: str
) -> None:
    outcome = mot_sim("export-car", tmp_path / "car.glb", *arguments)
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err.startswith(f"error: {told}")
    assert outcome.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_other_formats_and_places_are_refused(mot_sim: CommandLine, tmp_path: Path) -> None:
    outcome = mot_sim("export-car", tmp_path / "car.obj")
    assert (
        outcome.err == f"error: {tmp_path / 'car.obj'}: cars are written as GLB; end the name "
        "in .glb\n"
    )
    assert mot_sim("export-car", tmp_path / "none" / "car.glb").code == 2

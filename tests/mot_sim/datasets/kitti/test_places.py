"""Where things lie in a KITTI tree, and what is said when they do not."""

from pathlib import Path

import pytest

from mot_sim.datasets.kitti.places import (
    TRAINING_FRAMES,
    TRAINING_SIZES,
    available_sequences,
    beside_the_splits,
    find_root,
    require_file,
    require_sequence,
    training_row,
)
from tracker.errors import DatasetNotFound, UnknownName


def test_the_root_is_given_or_named_by_the_environment(
    tiny_tree: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("MOT_SIM_KITTI_ROOT", raising=False)
    assert find_root(str(tiny_tree)) == tiny_tree
    with pytest.raises(DatasetNotFound, match="set MOT_SIM_KITTI_ROOT or pass --root"):
        find_root()
    monkeypatch.setenv("MOT_SIM_KITTI_ROOT", str(tiny_tree))
    assert find_root() == tiny_tree
    assert available_sequences() == ["0030"]


def test_a_wrong_root_is_told_with_what_it_holds(tiny_tree: Path, tmp_path: Path) -> None:
    with pytest.raises(DatasetNotFound, match=r"nowhere: no KITTI root, no such folder;"):
        find_root(tmp_path / "nowhere")
    with pytest.raises(DatasetNotFound, match=r"training holds calib, label_02, oxts; set MOT"):
        find_root(tiny_tree / "training")
    (tmp_path / "empty").mkdir()
    with pytest.raises(DatasetNotFound, match=r"empty holds nothing"):
        find_root(tmp_path / "empty")


def test_a_missing_split_or_sequence_is_told_with_what_is_there(tiny_tree: Path) -> None:
    with pytest.raises(UnknownName, match=r"unknown split 'train'.*Did you mean 'training'"):
        require_sequence(tiny_tree, "train", "0030")
    with pytest.raises(DatasetNotFound, match=r"testing: no such split; .* holds detections, od"):
        require_sequence(tiny_tree, "testing", "0030")
    with pytest.raises(DatasetNotFound, match=r"no sequence '0099'; sequences there: 0030; set"):
        require_sequence(tiny_tree, "training", "0099")


def test_a_missing_file_is_told_with_its_neighbours(tmp_path: Path) -> None:
    for number in range(9):
        (tmp_path / f"{number}.txt").write_text("")
    assert require_file(tmp_path / "0.txt", "thing", "cure") == tmp_path / "0.txt"
    with pytest.raises(DatasetNotFound, match=r"9.txt: no thing; .* 7.txt, ... \(9 in all\); cure"):
        require_file(tmp_path / "9.txt", "thing", "cure")


def test_testing_has_folders_of_its_own(tmp_path: Path) -> None:
    assert beside_the_splits(tmp_path, "detections", "rrc", "training") == (
        tmp_path / "detections" / "rrc"
    )
    assert beside_the_splits(tmp_path, "detections", "rrc", "testing") == (
        tmp_path / "detections" / "rrc" / "testing"
    )


def test_kittis_own_sequences_are_known() -> None:
    assert len(TRAINING_FRAMES) == len(TRAINING_SIZES) == 21
    assert sum(TRAINING_FRAMES) == 8008
    assert training_row("0020", "training") == 20
    assert [training_row(*row) for row in (("0021", "training"), ("0001", "testing"))] == [None] * 2
    assert [training_row(name, "training") for name in ("mine", "001")] == [None] * 2

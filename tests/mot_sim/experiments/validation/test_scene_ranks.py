"""What a scene says of its ranks: as measured, or that nobody measured it."""

from pathlib import Path

import pytest

from mot_sim.experiments.validation import scene_ranks
from mot_sim.experiments.validation.scene_ranks import rank_line, read_ranks, write_ranks
from tests.mot_sim.experiments.validation.test_agreement import agreement
from tracker.errors import BadFile


def test_ranks_are_kept_and_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "ranks.toml"
    write_ranks({"street": agreement()}, path)
    write_ranks({"highway": agreement(14)}, path)
    assert set(read_ranks(path)) == {"street", "highway"}
    assert read_ranks(path)["street"] == {
        "trackers": 3, "MOTA": 1.0, "HOTA": 1.0, "IDF1": 1.0, "IDSW": 1.0,
    }  # fmt: skip
    path.write_text(path.read_text().replace("MOTA = 1", "MOTA = 0.2"))
    read_ranks.cache_clear()
    monkeypatch.setattr(scene_ranks.read_ranks.__wrapped__, "__defaults__", (path,))
    assert "do not read ranks by MOTA as KITTI's" in rank_line("street")
    assert "validate-sim --scenes moon" in rank_line("moon")
    read_ranks.cache_clear()


def test_a_file_without_a_metric_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "ranks.toml"
    path.write_text("[street]\nMOTA = 1\n")
    with pytest.raises(BadFile, match=r"\[street\]: give trackers"):
        read_ranks(path)

"""Profiles as files: what is shipped loads, what is written is read, what is wrong is told."""

from pathlib import Path

import pytest

from mot_sim.simulation.sensors.profile import (
    EFFECTS,
    PROFILES,
    Profile,
    find_profile,
    profile_lines,
    read_profile,
)
from mot_sim.simulation.sensors.scores import ScoreNoise
from tracker.errors import BadConfig, BadFile, UnknownName


@pytest.mark.parametrize("name", PROFILES)
def test_every_shipped_profile_loads_and_survives_writing(name, tmp_path: Path) -> None:
    profile = find_profile(name)
    assert profile.name == name
    path = tmp_path / "again.toml"
    path.write_text("\n".join(profile_lines(profile)))
    again = find_profile(str(path))
    assert profile_lines(again) == profile_lines(profile)


def test_perfect_has_no_effect() -> None:
    perfect = find_profile("perfect")
    assert all(getattr(perfect, name) is None for name in EFFECTS)


@pytest.mark.parametrize(
    ("text", "error", "told"),
    [
        ("version = 4", BadFile, "version 4; this mot-sim reads up to 3"),
        ("name = 'x'", BadFile, "version None"),
        ("version = 1\n[mises]\nbase = 1", UnknownName, "Did you mean 'misses'"),
        ("version = 1\n[misses]\nbasis = 1", UnknownName, "Did you mean 'base'"),
        ("version = 1\n[misses]\nshared = 0.1", BadConfig, "base is missing"),
        ("version = 1\n[misses]\nbase = 'high'", BadConfig, "is no number"),
        ("version = 1\n[misses]\nbase = 1\nby_truncation = 3", BadConfig, "no list of numbers"),
        (
            "version = 1\n[misses]\nbase = 1\nby_cut = [1]",
            UnknownName,
            "called 'by_truncation' now",
        ),
        ("version = 1\n[merges.memory]\nshares = [1]", UnknownName, "'autocorrelation' now"),
        ("version = 1\nmisses = 3", BadConfig, "no table"),
        ("version = 1\n[confusion]\nvan = 1.2", BadConfig, r"rates lie in \[0, 1\]"),
        ("version = 1\n[jitter.x]\nspread = -0.1", BadConfig, "spreads"),
        ("version = 1\n[[", BadFile, "no profile can be read"),
    ],
)
def test_what_is_wrong_in_a_file_is_told(text, error, told, tmp_path: Path) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(text)
    with pytest.raises(error, match=told):
        read_profile(path)


def test_an_older_profile_is_read_and_what_it_lacks_is_said(tmp_path: Path, caplog) -> None:
    path = tmp_path / "old.toml"
    path.write_text("version = 1\n[misses]\nbase = 3")
    assert read_profile(path).misses.base == 3.0
    assert [each.getMessage() for each in caplog.records] == [
        f"{path}: a profile of version 1, without [suppression]: cars close behind others are "
        "found too often; fit it again with `mot-sim calibrate`"
    ]
    path.write_text("version = 2\n[misses]\nbase = 3\n[duplicates]\nat_jumps = 0.1")
    assert read_profile(path).misses.base == 3.0
    assert read_profile(path).duplicates.at_unsure_jumps == 0.1  # it meant all boxes
    assert len(caplog.records) == 1


def test_scores_keep_all_digits(tmp_path: Path) -> None:
    path, tied = tmp_path / "tied.toml", 5.8208955223880705
    path.write_text("\n".join(profile_lines(Profile(scores=ScoreNoise((0.0, 1.0), (0.1, tied))))))
    assert read_profile(path).scores.log_odds[1] == tied


def test_a_file_that_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(BadFile, match="cannot be read: No such file"):
        find_profile(str(tmp_path / "none.toml"))
    with pytest.raises(UnknownName, match="Did you mean 'permatrack'"):
        find_profile("permatrak")

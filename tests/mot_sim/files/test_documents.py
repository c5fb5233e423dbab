"""JSON and TOML: what they hold, or an error that names the file."""

from pathlib import Path

import pytest

from mot_sim.files.documents import parse_json, read_json, read_toml, require_inside
from tracker.errors import BadFile


def test_what_is_held_comes_back(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text('{"a": [1, 2.5, null, true], "b": -9223372036854775807}')
    assert read_json(tmp_path / "a.json") == {"a": [1, 2.5, None, True], "b": 1 - 2**63}
    (tmp_path / "a.toml").write_text("a = 1\n[b]\nc = [1.5, 'x']\n")
    assert read_toml(tmp_path / "a.toml") == {"a": 1, "b": {"c": [1.5, "x"]}}


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("{", "a.json: no run of ours: Expecting property name"),
        ("[" * 20_000, "a.json: no run of ours: values inside values"),
        ("9" * 400, r"a.json: no run of ours: 9{20}\.\.\. is no number of 64 bits"),
        ("9" * 5000, "a.json: no run of ours: Exceeds the limit"),
        ("\ud83d".encode("utf-16", "surrogatepass"), "a.json: not a text file"),
    ],
)
def test_bad_json_is_refused(tmp_path: Path, text: str | bytes, told: str) -> None:
    path = tmp_path / "a.json"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(BadFile, match=told):
        read_json(path, "no run of ours")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("a = ", "a.toml: no profile: Invalid value"),
        ("a = " + "{b = " * 3000, "a.toml: no profile: values inside values"),
        ("a = [[" + "9" * 30 + "]]", "a.toml: no profile: 9{20}... is no number of 64 bits"),
        ("a = 1\na = 2", "a.toml: no profile: Cannot overwrite a value"),
    ],
)
def test_bad_toml_is_refused(tmp_path: Path, text: str, told: str) -> None:
    path = tmp_path / "a.toml"
    path.write_text(text)
    with pytest.raises(BadFile, match=told):
        read_toml(path, "no profile")


def test_a_text_is_named_as_it_is_told() -> None:
    with pytest.raises(BadFile, match=r"^line 3: not JSON: Expecting value"):
        parse_json("x", "line 3")


def test_a_named_path_must_lie_in_a_given_folder(tmp_path: Path) -> None:
    home, other = tmp_path / "home", tmp_path / "other"
    for folder in (home, other):
        folder.mkdir()
    (home / "link").symlink_to(other)
    require_inside(str(home / "a" / "b.toml"), "x", home)
    require_inside(str(other / "b.toml"), "x", home, other)
    for named in (str(other / "b.toml"), str(home / ".." / "b.toml"), str(home / "link" / "b")):
        with pytest.raises(BadFile, match=r"x: it names .*, which lies outside .*home; move it"):
            require_inside(named, "x", home)


def test_a_toml_file_that_would_take_long_is_refused_at_once(tmp_path: Path) -> None:
    dots, large = tmp_path / "dots.toml", tmp_path / "large.toml"
    dots.write_text(".".join("a" * 50_000) + " = 1\n")
    large.write_text("a = 1 # so\n" * 100_000)
    with pytest.raises(BadFile, match="deeper than anything of ours"):
        read_toml(dots)
    with pytest.raises(BadFile, match=r"large.toml: 1,100,000 bytes, where .* at most 200,000"):
        read_toml(large)

"""`result.json`: what a command found, written as a whole and read with care."""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.experiments.result_file import (
    RESULT_KINDS,
    Made,
    Result,
    made_here,
    read_result,
    write_result,
)
from mot_sim.tables import Column, Table
from tracker.errors import BadConfig, BadFile, BadOutput, UnknownName

TABLE = Table.of(
    "curves",
    "HOTA over jitter",
    ("tracker", "level", "HOTA", "HOTA low", "HOTA high"),
    (("default", 0.5, 0.81, 0.8, 0.82), ("paper", 1, None, None, None)),
    "rates are fractions",
)
MADE = Made("mot-sim sweep --axis 'a b'", {"python": "3.11"}, "ab12", False, (37, 400))
RESULT = Result("sweep", "jitter at intersections", MADE, (TABLE,), ("clips/one.mp4", "a.png"))
HUGE = json.dumps(
    {
        "format": 1, "kind": "run", "title": "", "files": [],
        "made": {"command": "", "versions": {}, "code": "", "finished": True, "trials": None},
        "tables": [{"name": "t", "title": "", "columns": ["a"], "rows": [[10**400]], "note": ""}],
    }
)  # fmt: skip


def test_a_result_comes_back_as_it_was_written(tmp_path: Path) -> None:
    path = write_result(tmp_path / "new", RESULT)
    assert path == tmp_path / "new" / "result.json"
    assert read_result(tmp_path / "new") == RESULT


numbers = st.integers(-(2**63) + 1, 2**63 - 1) | st.floats(allow_nan=False, allow_infinity=False)
cells = st.none() | numbers | st.text()


@given(
    kind=st.sampled_from(RESULT_KINDS),
    rows=st.lists(st.tuples(cells, cells), max_size=4),
    title=st.text(st.characters(exclude_categories=["Cs"])),
)
def test_any_table_comes_back(
    tmp_path_factory: pytest.TempPathFactory, kind: str, rows: list, title: str
) -> None:
    folder = tmp_path_factory.mktemp("any")
    table = Table.of("t", title, ("a", "b"), tuple(rows))
    result = Result(kind, title, MADE, (table,))
    write_result(folder, result)
    assert read_result(folder).title == title
    assert [
        value
        for row in read_result(folder).tables[0].rows
        for value in row
        if not isinstance(value, str)
    ] == [value for row in rows for value in row if not isinstance(value, str)]


def test_numbers_of_numpy_and_what_is_not_finite_become_plain(tmp_path: Path) -> None:
    table = Table.of("t", "", ("a", "b", "c"), ((np.float64(0.1), float("nan"), float("inf")),))
    path = write_result(tmp_path, replace(RESULT, tables=(table,), files=()))
    assert json.loads(path.read_text())["tables"][0]["rows"] == [[0.1, None, None]]
    assert read_result(tmp_path).tables[0].rows == ((0.1, None, None),)


def test_kinds_of_columns_come_back_and_may_be_absent(tmp_path: Path) -> None:
    columns = (Column("row", "name"), Column("part", "rate"), "share", "n")
    table = Table.of("t", "", columns, [("a", 0.1234, 0.5, 3)])
    path = write_result(tmp_path, replace(RESULT, tables=(table,), files=()))
    assert read_result(tmp_path).tables == (table,)
    content = json.loads(path.read_text())
    kinds = content["tables"][0].pop("kinds")
    assert kinds == ["name", "rate", "rate", "value"]
    path.write_text(json.dumps(content))
    (older,) = read_result(tmp_path).tables
    assert older.rows == table.rows
    assert older.columns[1].title == "part"
    assert older.shown_rows() == [("a", "0.123", "50.00", "3")]
    content["tables"][0]["kinds"] = ["name", "colour", "rate", "value"]
    path.write_text(json.dumps(content))
    with pytest.raises(BadFile, match="'colour' is no kind of column"):
        read_result(tmp_path)


def test_a_column_is_found_by_its_name() -> None:
    assert TABLE.column("HOTA") == (0.81, None)
    assert RESULT.table("curves") is TABLE
    assert RESULT.table("other") is None
    with pytest.raises(UnknownName, match="Did you mean 'HOTA'"):
        TABLE.column("HOTTA")


def test_a_row_of_another_length_is_refused() -> None:
    with pytest.raises(BadConfig, match="table t, row 2: 1 values where 2 belong"):
        Table.of("t", "", ("a", "b"), ((1, 2), (3,)))
    with pytest.raises(BadConfig, match="two columns of one name"):
        Table.of("t", "", ("a", "a"), ())


def test_an_unknown_kind_is_refused() -> None:
    with pytest.raises(UnknownName, match="Did you mean 'sweep'"):
        Result("sweeps", "", MADE, ())


@pytest.mark.parametrize(
    "name",
    ["/etc/passwd", "../other.png", "a/../../b.png", "", "C:\\a.png", "\\\\host\\a", "..\\b"],
)
def test_files_outside_the_folder_are_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(BadConfig, match="relative to the result's folder"):
        replace(RESULT, files=(name,))
    path = write_result(tmp_path, RESULT)
    content = json.loads(path.read_text())
    path.write_text(json.dumps({**content, "files": [name]}))
    with pytest.raises(BadFile, match=r"result\.json: file .* relative to the result's folder"):
        read_result(tmp_path)


def test_a_link_that_leads_out_of_the_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "secret.png").write_bytes(b"x")
    folder = tmp_path / "out"
    write_result(folder, replace(RESULT, files=("a.png",)))
    (folder / "a.png").symlink_to(tmp_path / "secret.png")
    with pytest.raises(BadFile, match=r"'a\.png' leads out of the folder by a link"):
        read_result(folder)


def test_a_folder_without_a_result_is_told_so(tmp_path: Path) -> None:
    with pytest.raises(BadFile, match=r"result\.json: no result there; name a folder"):
        read_result(tmp_path)
    with pytest.raises(BadFile, match="no result there"):
        read_result(tmp_path / "nowhere")


def test_half_of_a_file_is_told_with_its_line(tmp_path: Path) -> None:
    path = write_result(tmp_path, RESULT)
    text = path.read_text()
    path.write_text(text[: len(text) // 2])
    with pytest.raises(BadFile, match=r"result\.json:\d+: damaged: .*; run the command"):
        read_result(tmp_path)


@pytest.mark.parametrize(
    "text",
    ["[]", "null", HUGE, "{}", "3", '{"format": 1}', "[" * 100_000, '{"format": 1, "made": []}',
     '{"format": 1, "kind": "run", "title": 3, "made": {"trials": null}}'],
)  # fmt: skip
def test_what_is_no_result_is_told_so(tmp_path: Path, text: str) -> None:
    (tmp_path / "result.json").write_text(text)
    with pytest.raises(BadFile, match=r"result\.json"):
        read_result(tmp_path)


def test_binary_rubbish_is_told_so(tmp_path: Path) -> None:
    (tmp_path / "result.json").write_bytes(b"\xff\xfe\x00\x80")
    with pytest.raises(BadFile, match="not a text file"):
        read_result(tmp_path)


def test_a_result_of_another_format_is_told_so(tmp_path: Path) -> None:
    path = write_result(tmp_path, RESULT)
    path.write_text(json.dumps({**json.loads(path.read_text()), "format": 2}))
    with pytest.raises(BadFile, match="a result of format 2, this mot-sim reads 1"):
        read_result(tmp_path)


def test_half_characters_are_replaced(tmp_path: Path) -> None:
    path = write_result(tmp_path, RESULT)
    path.write_text(path.read_text().replace("jitter at intersections", r"jitter \ud800"))
    assert read_result(tmp_path).title == "jitter ?"


def test_a_folder_that_cannot_be_written_is_told_so(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(BadOutput, match="cannot be written"):
        write_result(tmp_path / "file", RESULT)


def test_what_made_it_names_the_command_as_it_was_typed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["/bin/mot-sim", "sweep", "--out", "a b"])
    made = made_here(finished=False, trials=(3, 4))
    assert made.command == "mot-sim sweep --out 'a b'"
    assert (made.finished, made.trials) == (False, (3, 4))
    assert made.versions["python"].startswith("3.")
    assert len(made.code) == 32


@pytest.mark.parametrize(
    ("key", "value", "told"),
    [
        ("titles", ["a", 3], "3 is no title of a column"),
        ("digits", [None, True], "True is no number of digits"),
        ("digits", [None, 99], "99 is no number of digits"),
        ("titles", ["a"], "zip"),
    ],
)
def test_titles_and_digits_of_columns_come_back_or_are_named(
    tmp_path: Path, key: str, value: list, told: str
) -> None:
    columns = (Column("cars", "name"), Column("centre, m", "value", "centre_median", digits=2))
    table = Table.of("t", "", columns, [("all", 1.2345)])
    path = write_result(tmp_path, replace(RESULT, tables=(table,), files=()))
    assert read_result(tmp_path).tables == (table,)
    content = json.loads(path.read_text())
    content["tables"][0][key] = value
    path.write_text(json.dumps(content))
    with pytest.raises(BadFile, match=told):
        read_result(tmp_path)

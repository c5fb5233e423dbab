"""Tables of numbers: what is read, and that errors name the file, the line and the value."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mot_sim.files.text import MAX_NUMBER, read_table
from tests.mot_sim.datasets.conftest import write
from tracker.errors import BadFile

COLUMNS = ("frame", "x", "y")


def test_rows_become_columns_whatever_the_line_ends(tmp_path: Path) -> None:
    path = tmp_path / "table.txt"
    path.write_bytes(b"\xef\xbb\xbf0, 1.5 ,-2\r\n\r\n1,2.5,3e2\r\n")
    table = read_table(path, COLUMNS, delimiter=",")
    assert len(table) == 2
    assert table["x"].tolist() == [1.5, 2.5]
    assert table.block(["y", "frame"]).tolist() == [[-2.0, 0.0], [300.0, 1.0]]
    assert table.integers("frame").tolist() == [0, 1]


@pytest.mark.parametrize("text", ["", "\n", "  \n\n"])
def test_a_file_without_rows_is_an_empty_table(tmp_path: Path, text: str) -> None:
    table = read_table(write(tmp_path / "table.txt", text), COLUMNS)
    assert len(table) == 0
    assert table.finite(COLUMNS).shape == (0, 3)
    assert table.integers("frame").shape == (0,)


def test_words_stay_words(tmp_path: Path) -> None:
    table = read_table(
        write(tmp_path / "t.txt", "1 Car 2\n"), ("frame", "type", "x"), words=["type"]
    )
    assert table["type"].tolist() == ["Car"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0,1,2\n1,2\n", ":2: 2 values where 3 belong: '1,2'"),
        ("0,1,2\n\n1,2,3,4\n", ":3: 4 values where 3 belong: '1,2,3,4'"),
        ("0,1,2\n1,2,\n", ":2: y is '', which is no number"),
        ("0,one,2\n", ":1: x is 'one', which is no number; a row is frame x y"),
        ("0,1_0,2\n", ":1: x is '1_0', which is no number"),
        ("0 1 2\n", ":1: 1 values where 3 belong"),
    ],
)
def test_bad_rows_are_named_by_line_and_value(tmp_path: Path, text: str, message: str) -> None:
    path = write(tmp_path / "table.txt", text)
    with pytest.raises(BadFile, match=re.escape(f"{path}{message}")):
        read_table(path, COLUMNS, delimiter=",")


@pytest.mark.parametrize("value", ["nan", "inf", "-inf", "NaN"])
def test_what_is_not_finite_is_refused_with_its_line(tmp_path: Path, value: str) -> None:
    path = write(tmp_path / "t.txt", f"0 1 2\n\n1 {value} 3\n")
    table = read_table(path, COLUMNS)
    with pytest.raises(BadFile, match=rf"t.txt:3: x is not finite: x {value.lower()}; leave"):
        table.finite(["frame", "x"])
    assert table.finite(["frame", "y"]).shape == (2, 2)


@pytest.mark.parametrize("value", ["1.5", "1e+300"])
def test_fractions_and_giants_are_no_whole_numbers(tmp_path: Path, value: str) -> None:
    table = read_table(write(tmp_path / "t.txt", f"0 1 2\n{value} 1 2\n"), COLUMNS)
    message = f"t.txt:2: frame is not a whole number: frame {value}"
    with pytest.raises(BadFile, match=re.escape(message)):
        table.integers("frame")


def test_numbers_below_the_lowest_are_refused(tmp_path: Path) -> None:
    table = read_table(write(tmp_path / "t.txt", "0 1 2\n-1 1 2\n"), COLUMNS)
    with pytest.raises(BadFile, match=r"t.txt:2: frame below 0: frame -1; frames of this format"):
        table.integers("frame", 0)


def test_the_first_line_chooses_among_variants(tmp_path: Path) -> None:
    variants = {2: ["a", "b"]}
    path = write(tmp_path / "t.txt", "1 2\n")
    table = read_table(path, lambda fields: variants.get(len(fields)))
    assert table["b"].tolist() == [2.0]
    with pytest.raises(BadFile, match=r":1: no known format has 3 values a row: '1 2 3'"):
        read_table(write(path, "1 2 3\n"), lambda fields: variants.get(len(fields)))
    with pytest.raises(BadFile, match=r":1: no known format has 0 values a row"):
        read_table(write(path, ""), lambda fields: variants.get(len(fields)))


def test_a_header_is_no_row_but_counts_as_a_line(tmp_path: Path) -> None:
    path = write(tmp_path / "t.csv", "x,frame\n1,0\n2,nan\n")
    table = read_table(path, lambda fields: fields, delimiter=",", header=True)
    assert table["x"].tolist() == [1.0, 2.0]
    with pytest.raises(BadFile, match=r"t.csv:3: frame is not finite"):
        table.integers("frame")


def test_what_is_not_text_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "t.txt"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(BadFile, match="not a text file"):
        read_table(path, COLUMNS)
    with pytest.raises(BadFile, match=r"nowhere.txt: cannot be read: No such file"):
        read_table(tmp_path / "nowhere.txt", COLUMNS)
    with pytest.raises(BadFile, match="cannot be read: Is a directory"):
        read_table(tmp_path, COLUMNS)


@given(st.lists(st.tuples(*[st.floats(-MAX_NUMBER, MAX_NUMBER)] * 3), max_size=5))
def test_written_floats_are_read_bit_by_bit(
    tmp_path_factory: pytest.TempPathFactory, rows: list[tuple[float, float, float]]
) -> None:
    path = tmp_path_factory.mktemp("rows") / "t.txt"
    path.write_text("".join(" ".join(map(repr, row)) + "\n" for row in rows))
    table = read_table(path, COLUMNS)
    np.testing.assert_array_equal(table.finite(COLUMNS), np.array(rows).reshape(-1, 3))

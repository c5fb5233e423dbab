"""A folder of findings: tables as Parquet and CSV, and `result.json` for the report."""

from collections.abc import Sequence
from pathlib import Path

import pyarrow as pa
import pyarrow.csv as pacsv
import pyarrow.parquet as pq

from mot_sim.experiments.results.result_file import Result, ResultTable, made_here, write_result
from mot_sim.files.writing import whole_file


def write_tables(
    folder: Path,
    title: str,
    tables: Sequence[ResultTable],
    files: Sequence[str] = (),
    *,
    finished: bool = True,
    drives: tuple[int, int] | None = None,
) -> None:
    """Write NAME.parquet and NAME.csv of every table, and the result.

    files: pictures, relative to the folder. drives: done and wanted. Raises BadOutput.
    """
    for table in tables:
        content = _arrow(table)
        with whole_file(folder / f"{table.name}.parquet") as half:
            pq.write_table(content, half)
        with whole_file(folder / f"{table.name}.csv") as half:
            pacsv.write_csv(content, half)
    made = made_here(finished=finished, trials=drives)
    write_result(folder, Result("diagnosis", title, made, tuple(tables), tuple(files)))


def _arrow(table: ResultTable) -> pa.Table:
    """Columns of one type each: words, whole numbers or fractions."""
    columns = {}
    for name in table.columns:
        cells = table.column(name)
        kinds = {type(cell) for cell in cells if cell is not None}
        kind = pa.string() if str in kinds else pa.float64() if float in kinds else pa.int64()
        columns[name] = pa.array(cells, kind)
    return pa.table(columns)


__all__ = ["write_tables"]

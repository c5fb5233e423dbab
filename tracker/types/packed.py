"""Tables whose columns of numbers lie in two arrays, as kernels take and give them.

An array costs a call of a kernel about as long as ten rows of it do: so a kernel is handed the two
instead of a dozen. Columns are cut out of them, as views, where somebody looks.
"""

from collections.abc import Mapping
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, TypeVar

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from tracker.kernels import Kernel
from tracker.types.rows import Rows, assembled

PackedTable = TypeVar("PackedTable", bound="PackedRows")


NO_INTS = np.zeros(0, np.int64)
TAKE_ROWS = Kernel("tracker.kernels.tables", "take_rows")


class Packed(NamedTuple):
    """The columns of numbers of so many rows, each whole, one after the other; never modified."""

    length: int
    """How many rows there are."""
    floats: Float[Array, " _"]
    """Those of float64; other numbers may follow them."""
    ints: Int[Array, " _"]
    """Those of int64; other numbers may follow them."""


class ColumnBlock(NamedTuple):
    """Where a column lies among the packed ones."""

    before: int
    """How many numbers per row are packed before it, among those of its type."""
    width: int
    """How many numbers per row it has."""
    shape: tuple[int, ...] = ()
    """Of one entry."""
    is_whole: bool = False
    """Whether it holds whole numbers."""
    table: "type[PackedRows] | None" = None
    """Which table it is; None: an array."""

    def cut(self, packed: Packed) -> Any:
        """The column itself."""
        if self.table is not None:
            return self.table.of_packed(packed)
        count, array = packed.length, packed.ints if self.is_whole else packed.floats
        column = array[self.before * count : (self.before + self.width) * count]
        return column.reshape(count, *self.shape) if self.shape else column


class PackedRows(Rows):
    """Rows whose columns of numbers are also there as `Packed`."""

    BLOCKS: ClassVar[Mapping[str, ColumnBlock]] = {}
    """Where the columns lie, in their order; a table that is one of them begins the floats."""

    @classmethod
    def of_packed(cls: type[PackedTable], packed: Packed, **others: Any) -> PackedTable:
        """The table of these columns. others: those that are not packed."""
        return assembled(cls, {"packed": packed, **others})

    @cached_property
    def packed(self) -> Packed:
        """The columns of numbers, as kernels take them."""
        count = len(self)
        floats: list[Array] = []
        ints: list[Array] = []
        for name, block in self.BLOCKS.items():
            column = getattr(self, name)
            if block.table is not None:
                column = column.packed.floats[: block.width * count]
            (ints if block.is_whole else floats).append(column.reshape(-1))
        numbers = np.concatenate(floats), np.concatenate(ints or [NO_INTS])
        return Packed(count, *map(read_only, numbers))

    def __len__(self) -> int:
        mine = self.__dict__
        return mine["packed"].length if "packed" in mine else super().__len__()

    if not TYPE_CHECKING:  # else every name would be one of its attributes

        def __getattr__(self, name: str) -> Any:
            """A column of packed ones, cut out when somebody looks at it first."""
            packed, block = self.__dict__.get("packed"), self.BLOCKS.get(name)
            if packed is None or block is None:
                raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
            column = self.__dict__[name] = block.cut(packed)
            return column

    def take(self: PackedTable, rows: Any, axis: int = 0) -> PackedTable:
        """`select` for an array of row numbers."""
        mine, numbers = self.__dict__, np.asarray(rows)
        if "packed" not in mine or numbers.ndim != 1 or numbers.dtype != np.int64:
            return super().take(rows)
        (n, floats, ints), k = mine["packed"], len(numbers)
        widths, whole = type(self)._widths()
        out, out_whole = np.empty(int(widths.sum()) * k), np.empty(whole * k, np.int64)
        if not TAKE_ROWS(floats, ints, widths, whole, n, numbers, out, out_whole):
            return super().take(rows)  # which says what is wrong
        return self._rows_of(numbers, Packed(k, out, out_whole))

    def _rows_of(self: PackedTable, rows: Int[Array, " k"], packed: Packed) -> PackedTable:
        """These rows, of which the packed columns are known."""
        columns: dict[str, Any] = {"packed": packed}
        for name in self.__match_args__:
            block = self.BLOCKS.get(name)
            if block is None:
                column = getattr(self, name)
                columns[name] = None if column is None else column.take(rows, 0)
            elif block.table is not None:
                columns[name] = getattr(self, name)._rows_of(rows, packed)
        return assembled(type(self), columns)

    @classmethod
    @cache
    def _widths(cls) -> tuple[Int[Array, " _"], int]:
        """Of the packed columns of floats, those of its tables among them; how many have ints."""
        widths: list[int] = []
        for block in cls.BLOCKS.values():
            if block.table is not None:
                widths.extend(block.table._widths()[0].tolist())
            elif not block.is_whole:
                widths.append(block.width)
        return np.array(widths), sum(block.is_whole for block in cls.BLOCKS.values())

    def replaced(self: PackedTable, **columns: Any) -> PackedTable:
        """The same table with other columns of these names."""
        mine = self.__dict__
        if "packed" in mine and self.BLOCKS.keys().isdisjoint(columns):
            return assembled(type(self), {**mine, **columns})
        return super().replaced(**columns)

    def _columns(self) -> dict[str, Any]:
        if "packed" not in self.__dict__:
            return self.__dict__
        return {name: getattr(self, name) for name in self.__match_args__}

    def __getstate__(self) -> dict[str, Any]:
        """What is pickled and copied: the columns."""
        return self._columns()


def read_only(array: Array) -> Array:
    """The array itself, which can no longer be written to, nor what is cut out of it."""
    array.setflags(False)  # type: ignore[call-arg]  # by name it takes twice as long
    return array

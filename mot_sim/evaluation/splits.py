"""Parts of a data set: sequences and frames that a seqmap file names, halves of every drive."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from mot_sim.datasets import KittiSequence
from mot_sim.files.text import read_table
from tracker.errors import BadConfig, BadFile, UnknownName

HALVES = ("first-half", "second-half")


@dataclass(frozen=True)
class Split:
    """Which frames of which sequences are meant."""

    ranges: dict[str, range] | None = None
    """Frames by sequence, counted from 0; None: all sequences that are there."""
    frames: str | None = None
    """`first-half`, `second-half` of every drive, or `100-199`, both included; None: all."""
    seqmap: Path | None = None
    """The file that says the ranges; None: none does."""

    def __post_init__(self) -> None:
        if self.frames is not None and self.frames not in HALVES:
            _parsed(self.frames)

    @classmethod
    def of(cls, seqmap: Path | None, frames: str | None) -> "Split":
        """From the options `--seqmap FILE` and `--frames PART`; BadConfig for both at once."""
        if seqmap is not None and frames is not None:
            raise BadConfig("--seqmap and --frames both say which frames: give one of them")
        return cls(None if seqmap is None else read_seqmap(seqmap), frames, seqmap)

    def sequences(self, there: Sequence[str]) -> list[str]:
        """The names that are meant, of those that are there; UnknownName for one that is not."""
        if self.ranges is None:
            return list(there)
        for name in self.ranges:
            if name not in there:
                raise UnknownName(f"{self.seqmap}: {UnknownName.of('sequence', name, there)}")
        return list(self.ranges)

    def part(self, drive: KittiSequence) -> KittiSequence:
        """The frames of a drive that are meant; BadConfig for frames that it does not have."""
        wanted = self._range(drive)
        if wanted.start == 0 and wanted.stop == drive.frame_count:
            return drive
        if not (0 <= wanted.start < wanted.stop <= drive.frame_count):
            where = "" if self.seqmap is None else f"{self.seqmap}: "
            raise BadConfig(
                f"{where}sequence {drive.name} has frames 0..{drive.frame_count - 1}, not "
                f"{wanted.start}..{wanted.stop - 1}"
            )
        return drive.subset(wanted)

    def _range(self, drive: KittiSequence) -> range:
        count = drive.frame_count
        if self.ranges is not None:
            return self.ranges.get(drive.name, range(count))
        if self.frames is None:
            return range(count)
        half = count // 2
        halves = {HALVES[0]: range(half), HALVES[1]: range(half, count)}
        return halves[self.frames] if self.frames in halves else _parsed(self.frames)


def _parsed(text: str) -> range:
    """`100-199`: from the first to the last frame."""
    first, _, last = text.partition("-")
    if not (first.isdecimal() and last.isdecimal() and int(first) <= int(last)):
        raise BadConfig(f"frames {text!r}: give first-half, second-half, or FIRST-LAST: 100-199")
    return range(int(first), int(last) + 1)


def read_seqmap(path: Path) -> dict[str, range]:
    """The sequences and frames of a file with a line `NAME empty FIRST END` each.

    FIRST counts from 0, END is the number of the frame after the last, as in KITTI's own files.
    Raises BadFile for rows of another form, a sequence that stands twice, and empty ranges.
    """
    table = read_table(path, ("name", "empty", "first", "end"), words=("name", "empty"))
    first, end = table.integers("first", 0), table.integers("end", 0)
    table.reject(end <= first, "no frame", ["name", "first", "end"], "END is after the last frame")
    names = [str(name) for name in table["name"].tolist()]
    for row, name in enumerate(names):
        if name in names[:row]:
            raise BadFile(f"{table.place(row)}: sequence {name} stands there twice")
    if not names:
        raise BadFile(f"{path}: no sequence; a line is NAME empty FIRST END")
    return {
        name: range(start, stop)
        for name, start, stop in zip(names, first.tolist(), end.tolist(), strict=True)
    }

"""`mot-sim verify`: whether recorded episodes match their hashes and a new run."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from mot_sim.cli.options import Flag, Verbose
from mot_sim.cli.terminal import BROKEN, OK, Terminal

if TYPE_CHECKING:
    import mot_sim.simulation.episodes


@dataclass(frozen=True)
class Verify:
    """Check recorded episodes by their hashes and by a new run.

    mot-sim verify out/crossing

    Labels, detections and trajectories (--images: pictures too) are compared with the SHA-256 of
    the episode's metadata. Ends with exit code 1 when something differs, and names it.
    """

    episodes: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="DIR")]
    """A tree that `mot-sim record` wrote."""
    images: Flag = False
    """Decode and draw all pictures again too; takes as long as recording."""
    json: Flag = False
    """Print the findings as JSON instead of the table."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Check every episode and show what was found."""
        from mot_sim.simulation.episodes import verify_tree
        from mot_sim.simulation.registry import find_scene

        with terminal.progress() as advance:
            found = verify_tree(
                self.episodes, find_scene, self.images, lambda name, of: advance(name, total=of)
            )
        if self.json:
            terminal.write_json([{**vars(each), "same": each.is_same} for each in found])
        else:
            self._show(terminal, found)
        for each in found:
            if each.trouble is not None:
                terminal.note(f"{each.name}: {each.trouble}")
        if any(each.is_same and not each.is_bit_equal for each in found):
            terminal.note(
                "the last bits differ, no printed digit does: another CPU or build of NumPy "
                "rounds otherwise (docs/determinism.md); bits are equal on the same ones"
            )
        return OK if all(each.is_same for each in found) else BROKEN

    def _show(
        self, terminal: Terminal, found: "list[mot_sim.simulation.episodes.EpisodeVerification]"
    ) -> None:
        """One row per episode."""
        from mot_sim.simulation.episodes.verification import GROUPS
        from mot_sim.tables import Column, Table

        shown = [group for group in GROUPS if group != "pictures" or self.images]
        columns = [Column(name, "value") for name in ("episode", "frames", *shown, "verdict")]
        rows: tuple[tuple[str | float | int | None, ...], ...] = tuple(
            (
                each.name,
                each.frames,
                *(each.verdict(group) for group in shown),
                _verdict(each),
            )
            for each in found
        )
        terminal.show(Table(tuple(columns), rows))


def _verdict(found: "mot_sim.simulation.episodes.EpisodeVerification") -> str:
    """One or two words on an episode."""
    if found.is_same:
        return "same" if found.is_bit_equal else "same digits"
    return "trouble" if found.trouble else "differs"

"""The picture of the architecture, drawn from the imports of the code as it is.

    python -m benchmarks.architecture docs/architecture.svg

Boxes are the packages of `mot_sim` (and `tracker` and `scenes`), each with the first line of its
docstring and its size. A package stands one floor above the highest package that it imports.
Arrows lead from an importer down to what it imports, with the number of imports; an arrow is left
out where a chain of other arrows leads to the same place. The matrix below holds all counts.
"""

import argparse
import ast
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from html import escape
from itertools import pairwise
from pathlib import Path
from textwrap import wrap

ROOT = Path(__file__).parents[1]
PACKAGES = ("tracker", "mot_sim", "scenes")
FACE = "mot_sim"  # its __init__: what it hands on to users

PAGE_WIDTH, MARGIN = 1200.0, 24.0
BOX_WIDTH, BOX_HEIGHT, FLOOR_HEIGHT = 208.0, 92.0, 158.0
PASSAGE_WIDTH = 24.0  # of an arrow that passes a floor
LETTERS = 32  # of a line of text in a box
CELL, LABEL_WIDTH = 46.0, 110.0  # of the matrix
FILLS = ("#dcecf7", "#fff3d6", "#e3f3e6")  # of the tracker, the testbed, the scenes
INK, FAINT, ARROW = "#1c2833", "#66788a", "#4a6a8a"
SWEEPS = 8  # passes over the floors that put boxes below what imports them


@dataclass(frozen=True)
class Package:
    """A box: lines and files of code, and the first line of the docstring."""

    name: str
    lines: int
    files: int
    about: str


@dataclass(frozen=True)
class Architecture:
    """Packages by name, and the number of import statements from one to another."""

    packages: dict[str, Package]
    imports: Counter[tuple[str, str]]

    @classmethod
    def of(cls, root: Path) -> "Architecture":
        """Read from the source under a root."""
        files: dict[str, list[Path]] = {}
        imports: Counter[tuple[str, str]] = Counter()
        for package in PACKAGES:
            for path in sorted((root / package).rglob("*.py")):
                here = room_of(path.relative_to(root).with_suffix("").parts)
                files.setdefault(here, []).append(path)
                for module in imported(path):
                    there = room_of(tuple(module.split(".")))
                    if module.partition(".")[0] in PACKAGES and there != here:
                        imports[here, there] += 1
        packages = {}
        for name, paths in files.items():
            lines = sum(len(path.read_text().splitlines()) for path in paths)
            first = ast.get_docstring(ast.parse(paths[0].read_text())) or ""
            packages[name] = Package(name, lines, len(paths), first.partition("\n")[0])
        return cls(packages, imports)

    def below(self, name: str) -> list[str]:
        """What a package imports."""
        return [there for here, there in self.imports if here == name]

    @cached_property
    def floors(self) -> dict[str, int]:
        """The floor of each package: 0 imports nothing. Raises ValueError for a circle."""
        found: dict[str, int] = {}
        while len(found) < len(self.packages):
            new = {
                name: 1 + max((found[there] for there in self.below(name)), default=-1)
                for name in self.packages.keys() - found.keys()
                if all(there in found for there in self.below(name))
            }
            if not new:
                raise ValueError(f"a circle among {sorted(self.packages.keys() - found.keys())}")
            found |= new
        return found

    def reachable(self, name: str) -> set[str]:
        """What a package imports, directly or through others."""
        return {name}.union(*(self.reachable(there) for there in self.below(name)))

    @cached_property
    def arrows(self) -> list[tuple[str, str]]:
        """The imports that no chain of others implies."""
        return [
            (here, there)
            for here, there in self.imports
            if not any(
                there in self.reachable(other) for other in self.below(here) if other != there
            )
        ]

    @cached_property
    def order(self) -> list[str]:
        """From the top floor to the ground."""
        return sorted(self.packages, key=lambda name: (-self.floors[name], name))


def room_of(parts: tuple[str, ...]) -> str:
    """The box of a module: `metrics` of mot_sim.metrics.clear, `tracker` of all of the tracker."""
    inner = parts[1:2] if parts[0] == "mot_sim" and parts[1:2] != ("__init__",) else ()
    return inner[0] if inner else parts[0]


def imported(path: Path) -> list[str]:
    """The modules that the import statements of a file name, one for each statement and module."""
    found = []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            found.append(node.module)
    return found


def chains_of(house: Architecture) -> dict[tuple[str, str], list[str]]:
    """For each arrow what it joins on its way down: boxes, and a place on each floor between."""
    chains = {}
    for here, there in house.arrows:
        between = range(house.floors[here] - 1, house.floors[there], -1)
        chains[here, there] = [here, *(f"{here}>{there}@{floor}" for floor in between), there]
    return chains


def places_of(house: Architecture, chains: dict[tuple[str, str], list[str]]) -> dict[str, float]:
    """The x of the middle of each box and of each place that an arrow passes through."""
    floors: dict[int, list[str]] = {}
    joined: dict[str, list[str]] = {}
    for name in house.order:
        floors.setdefault(house.floors[name], []).append(name)
    for chain in chains.values():
        for name in chain[1:-1]:
            floors[int(name.partition("@")[2])].append(name)
        for upper, lower in pairwise(chain):
            joined.setdefault(upper, []).append(lower)
            joined.setdefault(lower, []).append(upper)
    place = {name: x for names in floors.values() for name, x in spread(names, house)}
    for _ in range(SWEEPS):
        for names in floors.values():
            wanted = {
                name: sum(place[other] for other in joined[name]) / len(joined[name])
                for name in names
            }
            place.update(spread(sorted(names, key=lambda name: (wanted[name], name)), house))
    return place


def spread(names: list[str], house: Architecture) -> Iterator[tuple[str, float]]:
    """The boxes and places of a floor over the width of the page, in this order."""
    widths = [BOX_WIDTH if name in house.packages else PASSAGE_WIDTH for name in names]
    gap = (PAGE_WIDTH - 2.0 * MARGIN - sum(widths)) / len(names)
    x = MARGIN
    for name, width in zip(names, widths, strict=True):
        yield name, x + 0.5 * (gap + width)
        x += gap + width


def text(x: float, y: float, content: str, size: int, colour: str = INK, **more: str) -> str:
    """An SVG text; more: attributes, with _ for -."""
    attributes = "".join(f' {name.replace("_", "-")}="{value}"' for name, value in more.items())
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size}" fill="{colour}"{attributes}>'
        f"{escape(content)}</text>"
    )


def box(package: Package, x: float, y: float, width: float) -> list[str]:
    """A package as a box. x: of its middle; y: of its upper edge."""
    fill = FILLS[{"tracker": 0, "scenes": 2}.get(package.name, 1)]
    left = x - 0.5 * width
    size = f"{package.lines:,} lines, {package.files} file{'s' * (package.files > 1)}"
    lines = wrap(package.about.replace("`", ""), round(LETTERS * width / BOX_WIDTH))[:3]
    return [
        f'<rect x="{left:.1f}" y="{y:.1f}" width="{width:.1f}" height="{BOX_HEIGHT}" rx="7" '
        f'fill="{fill}" stroke="{INK}" stroke-width="1"/>',
        text(x, y + 20, package.name, 15, text_anchor="middle", font_weight="bold"),
        text(x, y + 36, size, 10, FAINT, text_anchor="middle"),
        *(
            text(x, y + 52 + 14 * row, line, 11, text_anchor="middle")
            for row, line in enumerate(lines)
        ),
    ]


def arrow(points: list[tuple[float, float]], count: int) -> tuple[str, list[str]]:
    """A line down through some points, curved between floors; the count on its first curve.

    points: an even number of them; between the second and the third it runs through a floor.
    """
    path = f"M{points[0][0]:.1f},{points[0][1]:.1f}"
    for number, ((x0, y0), (x1, y1)) in enumerate(pairwise(points)):
        bend = 0.5 * (y1 - y0)
        curve = f" C{x0:.1f},{y0 + bend:.1f} {x1:.1f},{y1 - bend:.1f} {x1:.1f},{y1:.1f}"
        path += curve if number % 2 == 0 else f" L{x1:.1f},{y1:.1f}"
    x, y = (0.5 * (first + second) for first, second in zip(*points[:2], strict=True))
    line = (
        f'<path d="{path}" fill="none" stroke="{ARROW}" '
        f'stroke-width="{1.0 + 0.35 * count**0.5:.2f}" marker-end="url(#tip)"/>'
    )
    return line, [
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="11" fill="white" stroke="{ARROW}"/>',
        text(x, y + 4, str(count), 11, text_anchor="middle"),
    ]


def floors_of(house: Architecture, top: float) -> tuple[list[str], float]:
    """The boxes on their floors with the arrows; where they end."""
    highest = max(house.floors.values())
    chains = chains_of(house)
    x = places_of(house, chains)
    y = {name: top + FLOOR_HEIGHT * (highest - house.floors[name]) for name in house.order}
    drawn: list[str] = []
    counts: list[str] = []  # above all lines
    for (here, there), chain in chains.items():
        start, end = foot(x[here], x[chain[1]]), foot(x[there], x[chain[-2]])
        if house.floors[there] == 0:  # as wide as the page: it is met right below
            end = x[chain[-2]]
        points = [(start, y[here] + BOX_HEIGHT)]
        for floor, name in enumerate(chain[1:-1], 1):
            upper = y[here] + FLOOR_HEIGHT * floor
            points += [(x[name], upper), (x[name], upper + BOX_HEIGHT)]
        line, count = arrow([*points, (end, y[there] - 7.0)], house.imports[here, there])
        drawn.append(line)
        counts += count
    drawn += counts
    for name in house.order:
        is_ground = house.floors[name] == 0
        middle = 0.5 * PAGE_WIDTH if is_ground else x[name]
        width = PAGE_WIDTH - 2.0 * MARGIN if is_ground else BOX_WIDTH
        drawn += box(house.packages[name], middle, y[name], width)
    return drawn, top + FLOOR_HEIGHT * highest + BOX_HEIGHT


def foot(x: float, other: float) -> float:
    """Where an arrow to or from `other` meets a box whose middle is at x."""
    return x + 0.35 * BOX_WIDTH * max(-1.0, min(1.0, (other - x) / (0.5 * PAGE_WIDTH)))


def matrix_of(house: Architecture, top: float) -> tuple[list[str], float]:
    """All counts: a row per importer, a column per imported package; where it ends."""
    rows = [name for name in house.order if house.below(name)]
    columns = [name for name in house.order if any(there == name for _, there in house.imports)]
    left = 0.5 * (PAGE_WIDTH - LABEL_WIDTH - CELL * len(columns)) + LABEL_WIDTH
    head = top + 84.0
    drawn = [text(MARGIN, top, "Imports, importer by imported package", 15, font_weight="bold")]
    for column, name in enumerate(columns):
        x = left + CELL * (column + 0.5)
        turn = f"rotate(-50 {x:.1f} {head - 6:.1f})"
        drawn.append(text(x, head - 6, name, 11, transform=turn))
    highest = max(house.imports.values())
    for row, here in enumerate(rows):
        y = head + 0.6 * CELL * row
        drawn.append(text(left - 8, y + 18, here, 11, text_anchor="end"))
        for column, there in enumerate(columns):
            count = house.imports[here, there]
            shade = 0.08 + 0.6 * (count / highest) ** 0.5 if count else 0.0
            x = left + CELL * column
            drawn.append(
                f'<rect x="{x:.1f}" y="{y:.1f}" width="{CELL}" height="{0.6 * CELL:.1f}" '
                f'fill="{ARROW}" fill-opacity="{shade:.2f}" stroke="#d5dce3"/>'
            )
            if count:
                drawn.append(text(x + 0.5 * CELL, y + 18, str(count), 11, text_anchor="middle"))
    return drawn, head + 0.6 * CELL * len(rows)


def picture(house: Architecture) -> str:
    """The whole picture as SVG."""
    upper, end = floors_of(house, MARGIN)
    lower, bottom = matrix_of(house, end + 52.0)
    height = bottom + MARGIN
    return "\n".join([
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {PAGE_WIDTH:.0f} {height:.0f}" '
        'font-family="DejaVu Sans, Verdana, Arial, sans-serif">',
        '<defs><marker id="tip" viewBox="0 0 10 10" refX="5" refY="5" markerWidth="9" '
        f'markerHeight="9" markerUnits="userSpaceOnUse" orient="auto"><path d="M0,0 L10,5 L0,10 z" '
        f'fill="{ARROW}"/></marker></defs>',
        f'<rect width="{PAGE_WIDTH:.0f}" height="{height:.0f}" fill="white"/>',
        *upper, *lower, "</svg>", "",
    ])  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("out", type=Path, help="the SVG to write")
    out = parser.parse_args().out
    house = Architecture.of(ROOT)
    out.write_text(picture(house), encoding="utf-8")
    print(f"{len(house.packages)} packages, {len(house.arrows)} arrows: {out}")


if __name__ == "__main__":
    main()

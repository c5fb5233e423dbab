"""The lowest versions that pyproject.toml allows, as requirements for pip.

    python tests/lowest_versions.py > lowest.txt

One line `name==version` for each dependency of the package itself. A lower bound must be a release
that exists: pip refuses one that does not.
"""

import re
import sys
import tomllib
from pathlib import Path

PROJECT = Path(__file__).parents[1] / "pyproject.toml"
REQUIREMENT = re.compile(r"([A-Za-z0-9._-]+)\s*>=\s*([0-9][0-9A-Za-z.]*)\s*(?:,|$)")


def lowest_versions(requirements: list[str]) -> list[str]:
    """`name==version` for each `name>=version,...`. Raises ValueError where there is no bound."""
    pins = []
    for requirement in requirements:
        bound = REQUIREMENT.match(requirement)
        if bound is None:
            raise ValueError(f"{requirement!r} has no lower bound: write name>=version")
        pins.append(f"{bound[1]}=={bound[2]}")
    return pins


def main() -> None:
    """Print the pins of pyproject.toml."""
    project = tomllib.loads(PROJECT.read_text())["project"]
    sys.stdout.write("\n".join(lowest_versions(project["dependencies"])) + "\n")


if __name__ == "__main__":
    main()

"""`mot-sim`, and `python -m mot_sim`."""

import sys
from collections.abc import Sequence

from mot_sim.cli import run


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and give its exit code; the process's arguments unless given."""
    return run(sys.argv[1:] if arguments is None else arguments)


if __name__ == "__main__":
    sys.exit(main())

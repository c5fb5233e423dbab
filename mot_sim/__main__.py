"""`mot-sim`, and `python -m mot_sim`."""

import sys
from collections.abc import Sequence

INTERRUPTED = 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and give its exit code; the process's arguments unless given."""
    try:
        from mot_sim.cli import run  # takes a moment, in which Ctrl-C may come

        return run(sys.argv[1:] if arguments is None else arguments)
    except KeyboardInterrupt:
        sys.stderr.write("error: interrupted\n")
        return INTERRUPTED


if __name__ == "__main__":
    sys.exit(main())

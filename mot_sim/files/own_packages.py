"""Whether the packages of this project are the ones that Python finds under their names."""

import sys
from importlib.util import find_spec
from pathlib import Path

OWN_PACKAGES = ("tracker", "scenes")


def hidden_package() -> str | None:
    """What hides one of our packages, and the cure; None where none is hidden.

    A file or folder of the same name that stands earlier on Python's path is found in its place.
    """
    home = Path(__file__).resolve().parents[2]
    for name in OWN_PACKAGES:
        place = _place_of(name)
        if place is None or not place.is_relative_to(home / name):
            found = "is not installed" if place is None else f"is hidden by {place}"
            cure = (
                "install mot-sim again"
                if place is None
                else (
                    "rename that file or folder, or work in another folder "
                    f"(Python looks into {place_on_path(place)} first)"
                )
            )
            return f"mot-sim's own package '{name}' {found}: {cure}"
    return None


def _place_of(name: str) -> Path | None:
    """The file or folder that Python finds under a name; None for none."""
    try:
        spec = find_spec(name)
    except (ImportError, ValueError):  # a module made by hand, without a file
        return None
    places = [] if spec is None else [spec.origin, *(spec.submodule_search_locations or ())]
    return next((Path(place).resolve() for place in places if place), None)


def place_on_path(place: Path) -> Path:
    """The folder of Python's path that a file or a package was found in."""
    folders = {Path(entry or ".").resolve() for entry in sys.path}
    return next((parent for parent in place.parents if parent in folders), place.parent)

"""Where what can be made again is kept between runs."""

import os
from pathlib import Path


def user_cache(part: str) -> Path:
    """The folder of a part in the user's cache folder, by the XDG base directory specification."""
    home = os.environ.get("XDG_CACHE_HOME")
    return (Path(home) if home else Path.home() / ".cache") / "mot-sim" / part

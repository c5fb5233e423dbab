"""PyTorch, loaded when a network is trained and not before: it is an extra."""

from importlib import import_module
from typing import Any

from tracker.errors import NoTorch

CURE = "pip install 'mot-sim[train]' (the CPU build of torch is enough)"


def load_torch() -> Any:
    """The module `torch`. Raises NoTorch where it is not installed."""
    try:
        return import_module("torch")
    except ImportError as error:
        raise NoTorch(f"training needs PyTorch ({error}): {CURE}") from error

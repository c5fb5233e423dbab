"""What goes wrong when an environment is used wrongly: ours and Gymnasium's errors at once."""

from typing import Any

from gymnasium.error import InvalidAction, ResetNeeded
from gymnasium.spaces import Box, Space
from numpy import ndarray as Array

from tracker.errors import TrackingError, UnknownName


class BadAction(TrackingError, InvalidAction):
    """An action outside the action space."""


class OutOfTurn(TrackingError, ResetNeeded):
    """A step or a picture before the first reset, or a step after the end of the episode."""


def require_action(space: Space, action: Any, meaning: str) -> None:
    """BadAction for what is not in the space; meaning: what the actions are."""
    # Gymnasium warns of what is no array and looks into it; here it is refused.
    is_array = isinstance(action, Array) or not isinstance(space, Box)
    if not (is_array and space.contains(action)):
        raise BadAction(f"action {action!r} is not in {space}: {meaning}")


def require_options(options: dict[str, Any] | None, known: tuple[str, ...]) -> dict[str, Any]:
    """The options of a reset. Raises UnknownName."""
    for name in options or {}:
        if name not in known:
            raise UnknownName.of("option of reset", name, known)
    return options or {}

"""Environments that are pickled as how they were made and what has happened since their reset."""

from typing import Any

KEPT_ATTRIBUTES = ("spec", "_np_random", "_np_random_seed", "observation_space", "action_space")


class ReplayPickle:
    """A copy begins the same episode and does the same actions, so it goes on where this one is.

    _arguments: of the constructor. _episode: the number that an episode follows from; None
    where none has begun. _actions: since the reset.
    """

    _arguments: dict[str, Any]
    _episode: int | None
    _actions: list[Any]

    def _begin(self, episode: int) -> None:
        """Start an episode."""
        raise NotImplementedError

    def _advance(self, action: Any) -> None:
        """Do an action that is in the space."""
        raise NotImplementedError

    def __getstate__(self) -> dict[str, Any]:
        begun = None if self._episode is None else (self._episode, self._actions)
        kept = {name: getattr(self, name) for name in KEPT_ATTRIBUTES}
        return {"arguments": self._arguments, "begun": begun, "kept": kept}

    def __setstate__(self, pickled: dict[str, Any]) -> None:
        type(self).__init__(self, **pickled["arguments"])
        vars(self).update(pickled["kept"])
        if pickled["begun"] is not None:
            episode, actions = pickled["begun"]
            self._begin(episode)
            for action in actions:
                self._advance(action)

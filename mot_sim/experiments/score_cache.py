"""Scores as JSON, such that those of several drives can be combined later; kept by a hash."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from mot_sim.files.cache_folder import CacheFolder
from mot_sim.metrics import Clear, Devkit2018, Hota, Identity, Scores

CLEARS = {kind.__name__: kind for kind in (Clear, Devkit2018)}


def as_plain(scores: Scores) -> dict[str, Any]:
    """Counts and values over alpha, ready for JSON; `of_plain` gives the same back."""
    found: dict[str, Any] = {"kind": type(scores.clear).__name__, "clear": _plain(scores.clear)}
    if scores.hota is not None:
        found["hota"] = _plain(scores.hota)
    if scores.identity is not None:
        found["identity"] = _plain(scores.identity)
    return found


def of_plain(content: Mapping[str, Any]) -> Scores:
    """The scores. Raises KeyError and TypeError for what is none."""
    hota, identity = content.get("hota"), content.get("identity")
    return Scores(
        CLEARS[content["kind"]](**content["clear"]),
        None if hota is None else Hota(**{name: np.array(each) for name, each in hota.items()}),
        None if identity is None else Identity(**identity),
    )


def _plain(family: Any) -> dict[str, Any]:
    values = {each.name: getattr(family, each.name) for each in fields(family)}
    return {
        name: value.tolist() if hasattr(value, "tolist") else value
        for name, value in values.items()
    }


@dataclass(frozen=True)
class ScoreCache:
    """A folder of scores, a file each, by the hash of all that decides them; see `CacheFolder`."""

    folder: Path
    """The folder of the files."""

    @property
    def files(self) -> CacheFolder:
        """The files."""
        return CacheFolder(self.folder, "scores")

    def read(self, key: str) -> dict[str, Scores] | None:
        """Scores by the name of their drive; None where there are none."""
        return self.files.read(
            key, lambda content: {name: of_plain(each) for name, each in content.items()}
        )

    def write(self, key: str, scores: Mapping[str, Scores], about: Mapping[str, Any]) -> None:
        """Keep scores; about: what a person wants to know who opens the file."""
        content = {name: as_plain(each) for name, each in scores.items()}
        self.files.write(key, content, about=dict(about))

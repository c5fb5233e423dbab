"""Checkpoints of a training: written whole or not at all, read only by the training they are of."""

import io
import pickle
from pathlib import Path
from typing import TYPE_CHECKING

from mot_sim.datasets.writing import write_bytes
from mot_sim.training.pytorch import load_torch
from tracker.errors import BadConfig, BadFile, DatasetNotFound

if TYPE_CHECKING:
    from mot_sim.training.learning import Learner

FORMAT = 1
LATER = "take another --out, or leave out --resume to begin again"


def save_checkpoint(learner: "Learner", path: Path) -> None:
    """Everything that the training needs to go on."""
    held = io.BytesIO()
    content = {
        "format": FORMAT, "plan": learner.plan.told(), "step": learner.step,
        "network": learner.network.state_dict(), "mean": learner.mean.state_dict(),
        "optimiser": learner.optimiser.state_dict(), "curve": learner.curve,
        "lately": learner.lately,
    }  # fmt: skip
    load_torch().save(content, held)
    write_bytes(path, held.getvalue())


def load_checkpoint(learner: "Learner", path: Path) -> None:
    """Put a learner where the checkpoint was made; the file stays as it is.

    Raises DatasetNotFound without a file, BadFile for one that is damaged, BadConfig for one of
    another plan.
    """
    if not path.is_file():
        raise DatasetNotFound(f"no checkpoint at {path}: {LATER}")
    torch = load_torch()
    try:
        content = torch.load(path, map_location="cpu", weights_only=True)
        step, plan = int(content["step"]), dict(content["plan"])
        states = [content[name] for name in ("network", "mean", "optimiser")]
        curve, lately = list(content["curve"]), list(content["lately"])
    except (OSError, RuntimeError, ValueError, KeyError, TypeError, EOFError,
            pickle.UnpicklingError) as error:  # fmt: skip
        raise BadFile(f"{path} is no checkpoint ({type(error).__name__}): {LATER}") from error
    told = learner.plan.told()
    other = {name: (plan.get(name), told[name]) for name in told if plan.get(name) != told[name]}
    if content.get("format") != FORMAT or other:
        changed = ", ".join(f"{name} {was}, now {now}" for name, (was, now) in other.items())
        raise BadConfig(f"{path} is of another training ({changed or 'format'}): {LATER}")
    learner.network.load_state_dict(states[0])
    learner.mean.load_state_dict(states[1])
    learner.optimiser.load_state_dict(states[2])
    learner.step, learner.curve, learner.lately = step, curve, lately

"""The training itself: steps, checkpoints, the learning curve; stops and goes on as it likes."""

from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from mot_sim.draws import named_stream
from mot_sim.training.augment import as_detected, varied
from mot_sim.training.checkpoint import load_checkpoint, save_checkpoint
from mot_sim.training.crops import Crops
from mot_sim.training.loss import loss_of, wanted
from mot_sim.training.network import build_network, size_of
from mot_sim.training.plan import Plan
from mot_sim.training.pytorch import load_torch
from mot_sim.training.scores import Judged, judge
from tracker.shape import CROP_MARGIN, decode, network_input

CELLS = 16
WARM_UP = 150  # steps in which the rate of learning rises, a tenth of all at most
STEEPEST = 5.0  # norm of a step's gradient, at most
FIRST_ODDS = -5.5  # log odds of a cell: seen or not is even at first
CHECKPOINT = "checkpoint.pt"
JUDGED_AT_ONCE = 64
Tell = Callable[[str, int, int], None]


@dataclass(eq=False)
class Learner:
    """A network on its way. mean: of its weights over the last steps; curve: rows of a table."""

    plan: Plan
    network: Any
    mean: Any
    optimiser: Any
    step: int = 0
    curve: list[dict[str, float]] = field(default_factory=list)
    lately: list[float] = field(default_factory=list)

    @classmethod
    def begin(cls, plan: Plan) -> "Learner":
        """Before the first step; a function of the plan alone."""
        torch = load_torch()
        torch.manual_seed(plan.seed)
        network = build_network(size_of(plan.size)).to(memory_format=torch.channels_last)
        for name, parameter in network.named_parameters():
            if name.startswith("maps") and name.endswith("bias"):
                torch.nn.init.constant_(parameter, FIRST_ODDS)
        optimiser = torch.optim.AdamW(
            network.parameters(), plan.rate, weight_decay=plan.decay, fused=True
        )
        return cls(plan, network, deepcopy(network), optimiser)

    def learn(self, crops: Crops) -> float:
        """One step; the loss."""
        torch = load_torch()
        plan, half = self.plan, self.plan.batch // 2
        epoch, batch = divmod(self.step, plan.steps_an_epoch)
        order = named_stream(plan.seed, f"order of epoch {epoch}").permutation(len(crops))
        shown = varied(crops, order[batch * half : (batch + 1) * half], plan.seed, epoch)
        images = torch.from_numpy(network_input(shown.images))
        chances = torch.from_numpy(wanted(shown, CELLS)[0])
        for group in self.optimiser.param_groups:
            group["lr"] = rate_at(self.step, plan)
        self.network.train()
        with torch.autocast("cpu", torch.bfloat16):
            every, _ = self.network(images.to(memory_format=torch.channels_last))
        loss = loss_of(every, chances)
        self.optimiser.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(self.network.parameters(), STEEPEST)
        self.optimiser.step()
        self.step += 1
        self._average(torch)
        return float(loss.detach())

    def _average(self, torch: Any) -> None:
        """Move the mean weights a little towards those of now."""
        share = max(1.0 / self.plan.average, 1.0 / (1.0 + self.step / 4.0))
        with torch.no_grad():
            now = self.network.state_dict()
            for name, value in self.mean.state_dict().items():
                if value.dtype.is_floating_point:
                    value.lerp_(now[name], share)
                else:
                    value.copy_(now[name])

    def judge(self, held_out: Crops) -> Judged:
        """How good the mean weights are on crops as a camera gives them."""
        torch = load_torch()
        shown, found = as_detected(held_out, self.plan.seed), []
        self.mean.eval()
        with torch.no_grad():
            for start in range(0, len(held_out), JUDGED_AT_ONCE):
                some = shown.images[start : start + JUDGED_AT_ONCE]
                every, _ = self.mean(torch.from_numpy(network_input(some)))
                found.append(decode(every[-1].numpy()))
        longer = np.full(len(held_out), 1.0 / CROP_MARGIN)
        return judge(np.concatenate(found), shown.keypoints, shown.states, longer)


def rate_at(step: int, plan: Plan) -> float:
    """The rate of learning: up in a line, then down to nothing along a cosine."""
    warm = min(1.0, (step + 1) / min(WARM_UP, 1 + plan.steps // 10))
    return float(plan.rate * warm * 0.5 * (1.0 + np.cos(np.pi * step / plan.steps)))


def train(
    plan: Plan,
    crops: Crops,
    held_out: Crops,
    folder: Path,
    tell: Tell,
    resume: bool = False,
    save_every: int = 250,
) -> Learner:
    """Train to the end of the plan, with checkpoints on the way and one when interrupted."""
    learner, path = Learner.begin(plan), folder / CHECKPOINT
    if resume:
        load_checkpoint(learner, path)
    try:
        while learner.step < plan.steps:
            learner.lately.append(learner.learn(crops))
            words = f"loss {np.mean(learner.lately[-100:]):.3f}"
            if learner.step % plan.steps_an_epoch == 0:
                _note(learner, held_out)
            if learner.step % save_every == 0:
                save_checkpoint(learner, path)
            tell(words, learner.step, plan.steps)
    finally:
        if learner.step:
            save_checkpoint(learner, path)
    return learner


def _note(learner: Learner, held_out: Crops) -> None:
    """A row of the learning curve."""
    judged = learner.judge(held_out)
    learner.curve.append(
        {
            "epoch": learner.step / learner.plan.steps_an_epoch,
            "loss": float(np.mean(learner.lately)),
            "pck": judged.pck,
            "doubt": judged.doubt,
        }
    )
    learner.lately.clear()

"""Training of the keypoint network: its plan, steps, checkpoints, learning curve and scores."""

import io
from collections.abc import Callable
from copy import deepcopy
from dataclasses import asdict, dataclass, field
from pathlib import Path
from pickle import UnpicklingError
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, UInt8
from numpy import ndarray as Array

from mot_sim.files.writing import write_bytes
from mot_sim.simulation.random_numbers import named_stream
from mot_sim.simulation.truth import KeypointVisibility
from mot_sim.training.augmentation import augmented_crops, detected_crops
from mot_sim.training.keypoint_crops import Crops
from mot_sim.training.network import build_network, keypoint_loss, load_torch, size_of, target_maps
from mot_sim.training.warm_start import begin_with
from tracker.errors import BadConfig, BadFile, DatasetNotFound
from tracker.shape import CROP_MARGIN, decode, network_input

MAX_ERROR_SHARE = 0.1  # of the longer side of the box; nearer keypoints are right
CONFIDENCE_BINS = 10
MAP_CELLS = 16
WARM_UP_STEPS = 150  # in which the learning rate rises; at most a tenth of all
MAX_GRADIENT_NORM = 5.0
INITIAL_LOG_ODDS = -5.5  # of a cell: a keypoint is seen or not with even chances at first
CHECKPOINT_FILE = "checkpoint.pt"
CHECKPOINT_FORMAT = 2
RESUME_CURE = "take another --out, or leave out --resume to begin again"
SCORING_BATCH = 64
# What torch.load and reading its content raise for a damaged file.
UNREADABLE = (OSError, RuntimeError, KeyError, ValueError, TypeError, EOFError, UnpicklingError)
Progress = Callable[[str, int, int], None]  # what is done, how much is done, how much there is


@dataclass(frozen=True)
class TrainingPlan:
    """Everything that decides the result; the defaults are those of the shipped network.

    Raises BadConfig for values that are not allowed, UnknownName for an unknown size.
    """

    crops: int = 5_800
    """Crops to train on, at least half a batch; more are rendered for longer and teach more."""
    epochs: int = 15
    """Passes over all crops and their mirror images, 1 or more; training takes longer with more."""
    seed: int = 0
    """Seed of the first weights, the order of the crops and their augmentation."""
    size: str = "shipped"
    """Size of the network, one of SIZES."""
    held_out: int = 1_400
    """Further crops, from other places, for scoring only; 1 or more."""
    batch: int = 64
    """Crops per step, mirror images included; even, 2 or more."""
    rate: float = 2e-3
    """The highest learning rate, strictly between 0 and 1; raising it makes larger steps."""
    decay: float = 0.03
    """Decay of the weights, 0 or more and below 1; raising it keeps the weights smaller."""
    average: int = 400
    """Steps over which the exported weights are about averaged, 1 or more; more smooth more."""
    start: str = ""
    """SHA-256 of the weights that the training begins with; empty: random ones."""

    def __post_init__(self) -> None:
        for name in ("crops", "epochs", "held_out", "average"):
            if getattr(self, name) < 1:
                raise BadConfig(f"{getattr(self, name)} {name}: there is nothing to train with")
        if self.batch < 2 or self.batch % 2:
            raise BadConfig(f"batches of {self.batch}: give an even number, 2 or more")
        if self.crops < self.batch // 2:
            raise BadConfig(f"{self.crops} crops do not fill a batch of {self.batch}: give more")
        if not (0.0 < self.rate < 1.0 and 0.0 <= self.decay < 1.0):
            raise BadConfig(f"rate {self.rate:g}, decay {self.decay:g}: give shares below 1")
        size_of(self.size)

    @property
    def steps_per_epoch(self) -> int:
        """Batches per epoch; crops that fill no batch are left out of it."""
        return self.crops // (self.batch // 2)

    @property
    def steps(self) -> int:
        """Batches in total."""
        return self.epochs * self.steps_per_epoch

    def as_dict(self) -> dict[str, Any]:
        """The plan as it is written to files."""
        return asdict(self)


@dataclass(frozen=True, eq=False)
class KeypointScores:
    """Scores of predicted keypoints: one row per crop, one column per keypoint."""

    right: Bool[Array, "n k"]
    """Whether the keypoint is visible and found near its true place."""
    seen: Bool[Array, "n k"]
    """Whether the keypoint is truly visible."""
    confidence: Float[Array, "n k"]
    """The network's confidence, 0..1, that it sees the keypoint."""

    @property
    def pck(self) -> float:
        """The share of the visible keypoints that are right."""
        return float(self.right[self.seen].mean()) if self.seen.any() else float("nan")

    @property
    def reliability(self) -> Float[Array, "b 3"]:
        """Per bin of confidence (0 to .1, ...): its mean, the share seen and right, the count."""
        rows = np.minimum((self.confidence * CONFIDENCE_BINS).astype(np.int64), CONFIDENCE_BINS - 1)
        good, table = self.right & self.seen, np.full((CONFIDENCE_BINS, 3), np.nan)
        for row in range(CONFIDENCE_BINS):
            some = rows == row
            table[row, 2] = some.sum()
            if some.any():
                table[row, :2] = self.confidence[some].mean(), good[some].mean()
        return table

    @property
    def calibration_error(self) -> float:
        """Mean difference of confidence and share seen and right, over all keypoints."""
        mean, good, count = np.nan_to_num(self.reliability).T
        return float((np.abs(mean - good) * count).sum() / max(count.sum(), 1.0))


def score_keypoints(
    found: Float[Array, "n k 3"],
    keypoints: Float[Array, "n k 2"],
    states: UInt8[Array, "n k"],
    longer: Float[Array, " n"],
    share: float = MAX_ERROR_SHARE,
) -> KeypointScores:
    """Scores of found points (x, y, confidence). longer: the boxes' longer sides, same unit."""
    seen = states == KeypointVisibility.VISIBLE
    apart = found[:, :, :2] - np.where(seen[:, :, None], keypoints, 0.0)
    off = np.hypot(apart[:, :, 0], apart[:, :, 1])
    return KeypointScores((off <= share * longer[:, None]) & seen, seen, found[:, :, 2])


@dataclass(eq=False)
class KeypointTrainer:
    """A network in training."""

    plan: TrainingPlan
    """Everything that decides the result."""
    network: Any
    """The torch module that is trained."""
    mean: Any
    """A torch module with the average of the weights over the last steps, which is exported."""
    optimiser: Any
    """The torch optimiser of the network."""
    step: int = 0
    """Number of steps done."""
    curve: list[dict[str, float]] = field(default_factory=list)
    """The learning curve, one row per epoch: epoch, loss, pck (share right), doubt (calibration
    error)."""
    recent_losses: list[float] = field(default_factory=list)
    """Losses of the steps since the last row of the curve."""

    @classmethod
    def begin(cls, plan: TrainingPlan) -> "KeypointTrainer":
        """Before the first step; a function of the plan alone."""
        torch = load_torch()
        torch.manual_seed(plan.seed)
        network = build_network(size_of(plan.size)).to(memory_format=torch.channels_last)
        for name, parameter in network.named_parameters():
            if name.startswith("maps") and name.endswith("bias"):
                torch.nn.init.constant_(parameter, INITIAL_LOG_ODDS)
        optimiser = torch.optim.AdamW(
            network.parameters(), plan.rate, weight_decay=plan.decay, fused=True
        )
        return cls(plan, network, deepcopy(network), optimiser)

    def learn(self, crops: Crops) -> float:
        """One step; the loss."""
        torch = load_torch()
        plan, half = self.plan, self.plan.batch // 2
        epoch, batch = divmod(self.step, plan.steps_per_epoch)
        order = named_stream(plan.seed, f"order of epoch {epoch}").permutation(len(crops))
        shown = augmented_crops(crops, order[batch * half : (batch + 1) * half], plan.seed, epoch)
        images = torch.from_numpy(network_input(shown.images))
        chances = torch.from_numpy(target_maps(shown, MAP_CELLS)[0])
        for group in self.optimiser.param_groups:
            group["lr"] = rate_at(self.step, plan)
        self.network.train()
        with torch.autocast("cpu", torch.bfloat16):
            every, _ = self.network(images.to(memory_format=torch.channels_last))
        loss = keypoint_loss(every, chances)
        self.optimiser.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(self.network.parameters(), MAX_GRADIENT_NORM)
        self.optimiser.step()
        self.step += 1
        self._average(torch)
        return float(loss.detach())

    def _average(self, torch: Any) -> None:
        """Move the mean weights a little towards the current ones."""
        share = max(1.0 / self.plan.average, 1.0 / (1.0 + self.step / 4.0))
        with torch.no_grad():
            now = self.network.state_dict()
            for name, value in self.mean.state_dict().items():
                if value.dtype.is_floating_point:
                    value.lerp_(now[name], share)
                else:
                    value.copy_(now[name])

    def score(self, held_out: Crops) -> KeypointScores:
        """Scores of the mean weights on crops as a camera gives them."""
        torch = load_torch()
        shown, found = detected_crops(held_out, self.plan.seed), []
        self.mean.eval()
        with torch.no_grad():
            for start in range(0, len(held_out), SCORING_BATCH):
                some = shown.images[start : start + SCORING_BATCH]
                every, _ = self.mean(torch.from_numpy(network_input(some)))
                found.append(decode(every[-1].numpy()))
        longer = np.full(len(held_out), 1.0 / CROP_MARGIN)
        return score_keypoints(np.concatenate(found), shown.keypoints, shown.states, longer)


def rate_at(step: int, plan: TrainingPlan) -> float:
    """The learning rate: rises linearly, then falls to 0 along a cosine."""
    warm = min(1.0, (step + 1) / min(WARM_UP_STEPS, 1 + plan.steps // 10))
    return float(plan.rate * warm * 0.5 * (1.0 + np.cos(np.pi * step / plan.steps)))


def train(
    plan: TrainingPlan,
    crops: Crops,
    held_out: Crops,
    folder: Path,
    tell: Progress,
    resume: bool = False,
    save_every: int = 250,
    start: Path | None = None,
) -> KeypointTrainer:
    """Train to the end of the plan, with checkpoints on the way and one when interrupted.

    start: an ONNX file whose weights the training begins with.
    """
    trainer, path = KeypointTrainer.begin(plan), folder / CHECKPOINT_FILE
    if resume:
        load_checkpoint(trainer, path)
    elif start is not None:
        begin_with(trainer.network, start, crops, plan.seed)
        trainer.mean.load_state_dict(trainer.network.state_dict())
    try:
        while trainer.step < plan.steps:
            trainer.recent_losses.append(trainer.learn(crops))
            words = f"loss {np.mean(trainer.recent_losses[-100:]):.3f}"
            if trainer.step % plan.steps_per_epoch == 0:
                _note(trainer, held_out)
            if trainer.step % save_every == 0:
                save_checkpoint(trainer, path)
            tell(words, trainer.step, plan.steps)
    finally:
        if trainer.step:
            save_checkpoint(trainer, path)
    return trainer


def _note(trainer: KeypointTrainer, held_out: Crops) -> None:
    """A row of the learning curve."""
    scores = trainer.score(held_out)
    trainer.curve.append(
        {
            "epoch": trainer.step / trainer.plan.steps_per_epoch,
            "loss": float(np.mean(trainer.recent_losses)),
            "pck": scores.pck,
            "doubt": scores.calibration_error,
        }
    )
    trainer.recent_losses.clear()


def save_checkpoint(trainer: KeypointTrainer, path: Path) -> None:
    """Write everything that the training needs to continue."""
    held = io.BytesIO()
    content = {
        "format": CHECKPOINT_FORMAT,
        "plan": trainer.plan.as_dict(),
        "step": trainer.step,
        "network": trainer.network.state_dict(),
        "mean": trainer.mean.state_dict(),
        "optimiser": trainer.optimiser.state_dict(),
        "curve": trainer.curve,
        "recent_losses": trainer.recent_losses,
    }
    load_torch().save(content, held)
    write_bytes(path, held.getvalue())


def load_checkpoint(trainer: KeypointTrainer, path: Path) -> None:
    """Continue from a checkpoint; the file stays as it is.

    Raises DatasetNotFound without a file, BadFile for a damaged one, BadConfig for one of another
    plan or format.
    """
    if not path.is_file():
        raise DatasetNotFound(f"no checkpoint at {path}: {RESUME_CURE}")
    torch = load_torch()
    try:
        content = torch.load(path, map_location="cpu", weights_only=True)
        if content["format"] != CHECKPOINT_FORMAT:
            found = f"of format {content['format']}, not {CHECKPOINT_FORMAT}"
            raise BadConfig(f"{path} is {found}: {RESUME_CURE}")
        step, plan = int(content["step"]), dict(content["plan"])
        states = [content[name] for name in ("network", "mean", "optimiser")]
        curve, losses = list(content["curve"]), list(content["recent_losses"])
    except UNREADABLE as error:
        raise BadFile(f"{path} is no checkpoint ({type(error).__name__}): {RESUME_CURE}") from error
    own = trainer.plan.as_dict()
    other = {name: (plan.get(name), own[name]) for name in own if plan.get(name) != own[name]}
    if other:
        changed = ", ".join(f"{name} {was}, now {now}" for name, (was, now) in other.items())
        raise BadConfig(f"{path} is of another training ({changed}): {RESUME_CURE}")
    trainer.network.load_state_dict(states[0])
    trainer.mean.load_state_dict(states[1])
    trainer.optimiser.load_state_dict(states[2])
    trainer.step, trainer.curve, trainer.recent_losses = step, curve, losses

"""What a training is made of: everything that its result hangs on."""

from dataclasses import asdict, dataclass
from typing import Any

from mot_sim.training.network import size_of
from tracker.errors import BadConfig


@dataclass(frozen=True)
class TrainingPlan:
    """A training. The defaults are those of the shipped network.

    crops: how many are drawn. held_out: more of them, of other places, to judge on. epochs: each
    shows every crop once, and its mirror image. batch: crops in a step, mirror images counted.
    rate: of learning, at its highest. decay: of the weights. average: over about how many steps
    the shipped weights are a mean.
    """

    crops: int = 5_800
    epochs: int = 15
    seed: int = 0
    size: str = "shipped"
    held_out: int = 1_400
    batch: int = 64
    rate: float = 2e-3
    decay: float = 0.03
    average: int = 400

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
    def steps_an_epoch(self) -> int:
        """Batches in an epoch; what fills no batch waits for the next one."""
        return self.crops // (self.batch // 2)

    @property
    def steps(self) -> int:
        """Batches in all."""
        return self.epochs * self.steps_an_epoch

    def told(self) -> dict[str, Any]:
        """The plan as it stands in files."""
        return asdict(self)

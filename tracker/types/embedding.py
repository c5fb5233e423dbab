"""How objects looked when they were last seen: the descriptors that eq. 5 compares."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.types.detections import Detections
from tracker.types.rows import Rows


@dataclass(frozen=True, eq=False)
class Embedding(Rows):
    """How objects looked when they were last seen."""

    descriptor: Float[Array, "n d"]
    """psi of eq. 5, as last measured; NaN rows where it never was."""

    @classmethod
    def of(cls, detections: Detections) -> "Embedding | None":
        """Those of detections; None without a column of descriptors."""
        return None if detections.descriptor is None else cls(detections.descriptor)

    @property
    def is_complete(self) -> bool:
        """Whether a descriptor was measured in all rows."""
        return bool(np.isfinite(self.descriptor).all())

    def unknown(self, count: int) -> "Embedding":
        """`count` rows whose descriptors were not measured."""
        return Embedding(np.full((count, self.descriptor.shape[1]), np.nan))

    def filled_from(self, before: "Embedding | None") -> "Embedding":
        """The same, with the rows of `before` where nothing is known."""
        known = np.isfinite(self.descriptor).all(axis=1)
        if before is None or known.all():
            return self
        return Embedding(np.where(known[:, None], self.descriptor, before.descriptor))

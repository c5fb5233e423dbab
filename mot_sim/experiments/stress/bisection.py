"""The place at which something that only gets worse is bad enough: doubling, then halving."""

from collections.abc import Callable
from dataclasses import dataclass

NOWHERE = 1e-4  # of the first step: a place nearer to 0 than that is 0


@dataclass(frozen=True)
class Reach:
    """How places on an axis are searched, from 0 on.

    first: the first step. most: the farthest place. precision: how narrow a bracket must be, as
    a part of its far end; of whole places 1.
    """

    first: float
    most: float
    precision: float = 0.1
    is_whole: bool = False

    def bracket(self, is_bad: Callable[[float], bool]) -> tuple[float, float] | None:
        """Two places, the near one good and the far one bad; None where all are good.

        Place 0 is taken for good, and is not asked about.
        """
        near, far = 0.0, min(self.first, self.most)
        while not is_bad(far):
            if far >= self.most:
                return None
            near, far = far, min(2.0 * far, self.most)
        while not self._is_narrow(near, far):
            middle = 0.5 * (near + far)
            if self.is_whole:
                middle = float(int(middle))
            if is_bad(middle):
                far = middle
            else:
                near = middle
        return near, far

    def _is_narrow(self, near: float, far: float) -> bool:
        if self.is_whole:
            return far - near <= 1.0
        return far - near <= self.precision * far or far <= NOWHERE * self.first

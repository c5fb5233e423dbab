"""`mot-sim export-car`: a car of the fleet as GLB."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from mot_sim.cli.options import Verbose, option
from mot_sim.cli.terminal import OK, Terminal

if TYPE_CHECKING:
    from numpy import ndarray as Array


@dataclass(frozen=True)
class ExportCar:
    """Write a car of the fleet as GLB, for 3D programs.

    mot-sim export-car --body estate --paint red out/estate.glb

    mot-sim export-car --size 4.4,1.5,1.8 out/car.glb

    mot-sim export-car --coefficients=-0.3,0.1,0,0,0.05 out/shape.glb

    The shape is drawn by --seed, unless --size or --coefficients say which one it is.
    """

    out: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="OUT.glb")]
    """The file; an older one is replaced."""
    seed: int = 0
    """Of the drawn shape and paint."""
    body: Annotated[str | None, option("NAME", "drawn; with --size the nearest")] = None
    """sedan, hatchback, estate, suv, coupe, van or pickup."""
    size: Annotated[str | None, option("L,H,W")] = None
    """Length, height and width in metres of the car that is sought: the likeliest of about that."""
    paint: Annotated[str | None, option("NAME", "drawn")] = None
    """black, grey, silver, white, blue, red, green, brown or yellow."""
    coefficients: Annotated[str | None, option("NUMBERS")] = None
    """1 to 20 shape coefficients of eq. 1, in place of a drawn shape."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Write the car, and say how large it is."""
        import numpy as np

        from mot_sim.simulation.cars import export_car, load_fleet

        shape, paint = self._car()
        path = export_car(shape, self.out, self.paint or paint)
        length, height, width = load_fleet(len(shape)).size(np.asarray(shape)).tolist()
        terminal.write(
            f"{path}: {length:.2f} m long, {height:.2f} m high, {width:.2f} m wide, "
            f"{self.paint or paint}; coefficients {','.join(f'{b:.4f}' for b in shape.tolist())}\n"
        )
        return OK

    def _car(self) -> "tuple[Array, str]":
        """Shape coefficients, and the paint that is drawn."""
        import numpy as np

        from mot_sim.simulation.cars import load_fleet
        from tracker.errors import BadConfig

        if self.coefficients is not None and (self.size or self.body):
            other = "--size" if self.size else "--body"
            raise BadConfig(f"--coefficients and {other} both say the shape: keep one")
        fleet = load_fleet()
        drawn = fleet.sample(self.seed, np.array([0]), self.body)
        if self.coefficients is not None:
            return _numbers("--coefficients", self.coefficients), drawn.paints[0]
        if self.size is None:
            return drawn.coefficients[0], drawn.paints[0]
        size = _numbers("--size", self.size)
        if len(size) != 3 or not (np.isfinite(size).all() and (size > 0.0).all()):
            raise BadConfig(f"--size {self.size}: three numbers above 0, length,height,width")
        found = fleet.nearest(size, self.body or fleet.body_of(size)).coefficients
        assert found is not None
        return found, drawn.paints[0]


def _numbers(name: str, text: str) -> "Array":
    """Numbers between commas."""
    import numpy as np

    from tracker.errors import BadConfig

    try:
        return np.array([float(number) for number in text.split(",")])
    except ValueError:
        raise BadConfig(f"{name} {text}: write numbers between commas, as 1.5,-2,0") from None

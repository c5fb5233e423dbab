"""Do the two renderers draw the same cars? Over every scene; needs OpenGL.

python -m benchmarks.truth --agreement
"""

from collections.abc import Iterable

import cv2
import numpy as np

from mot_sim.simulation.imaging import view_of
from mot_sim.simulation.registry import SCENES, find_scene
from mot_sim.simulation.renderers import NO_INSTANCE, Rendered, find_renderer, silhouettes
from mot_sim.simulation.scene import Rollout

FRAMES = (0, 40, 80)
LARGE, HALF = 60.0, 0.5  # pixels high, and visible: whose masks are compared
OFF = 0.005  # of the depth


def far_from_edges(one: Rendered, other: Rendered) -> int:
    """How many pixels differ in their instance that are no neighbours of an edge."""
    ids = one.instances.astype(np.float32)
    low, high = cv2.erode(ids, np.ones((3, 3))), cv2.dilate(ids, np.ones((3, 3)))
    return int(((low == high) & (one.instances != other.instances)).sum())


def agreement_table(scenes: Iterable[str] = tuple(SCENES)) -> None:
    """The worst figures of each scene; depth: the share of pixels off by more than OFF."""
    raster, mesh = find_renderer("raster"), find_renderer("mesh")
    print("\nscene          large cars   mask IoU, least   visible, most apart   depth off by .5 %"
          "   pixels off, not at edges")  # fmt: skip
    for name in scenes:
        ious, apart, deep, pixels, off = [], [0.0], 0, 0, 0
        take = Rollout.of(find_scene(name, frames=max(FRAMES) + 1), 0)
        for frame in FRAMES:
            view = view_of(take, frame)
            one, other = raster.render(view), mesh.render(view)
            seen = silhouettes(view)
            for row, number in enumerate(seen.instances.tolist()):
                a, b = one.instances == number, other.instances == number
                height = seen.amodal_boxes[row, 3] - seen.amodal_boxes[row, 1]
                if height >= LARGE and seen.fraction[row] >= HALF:
                    ious.append((a & b).sum() / (a | b).sum())
                if seen.amodal[row] >= 100:
                    apart.append(abs(int(a.sum()) - int(b.sum())) / seen.amodal[row])
            same = (one.instances == other.instances) & (one.instances != NO_INSTANCE)
            deep += int((np.abs(one.depth[same] / other.depth[same] - 1.0) > OFF).sum())
            pixels += int(same.sum())
            off += far_from_edges(one, other)
        print(f"{name:14s}{len(ious):8d}{min(ious, default=1.0):18.3f}{max(apart):20.3f}"
              f"{deep / max(pixels, 1):20.5f}{off:22d}", flush=True)  # fmt: skip

"""A scene of your own: one car drives ahead of us, another overtakes both.

A scene is a function whose keyword arguments are its knobs. World coordinates: x forward, y right,
metres. Registered by the name of its module, a scene gets the knobs of all scenes too: weather,
houses, trees, furniture, and the detector's noise profile.
"""

import cv2

from mot_sim import SCENES, Scene, Tracker, Tracks, evaluate_sequence, find_scene, record
from mot_sim.simulation.traffic import Roads, Route, Script, Scripted
from mot_sim.simulation.traffic.roads import rectangle, stripe


def overtaking(*, speed: float = 14.0, frames: int = 60) -> Scene:
    """One car drives ahead of us, another overtakes both at `speed` metres per second."""

    def traffic(models):
        straight = [(-40.0, 0.0), (400.0, 0.0)]
        ego = Script(Route(straight), [(0.0, 8.0)], start=40.0)  # 8 m/s, 40 m along its way
        ahead = Script(Route(straight), [(0.0, 8.0)], start=65.0)
        fast = Script(Route([(-40.0, -3.5), (400.0, -3.5)]), [(0.0, speed)], start=20.0)
        return Scripted([ahead, fast], ego)

    length, sides = (-60.0, 500.0), (-5.5, 2.0)  # x and y of the asphalt
    middle = -1.75  # y of the line between the lanes
    road = [rectangle("asphalt", length, sides)]
    road += stripe((length[0], middle), (length[1], middle), dash=(3.0, 4.5))
    return Scene("overtaking", traffic, frames, Roads(tuple(road)))


if __name__ == "__main__":
    SCENES["overtaking"] = "own_scene:overtaking"  # module:function
    scene = find_scene("overtaking", speed=18.0, frames=25, weather="overcast")
    episode = record(scene, seed=1, renderer="raster")  # with images
    tracker, rows = Tracker.default(episode.camera), []
    for frame in episode:
        rows.append(tracker.step(frame))
    cv2.imwrite("own_scene.png", frame.image[..., ::-1])  # the last frame; images are RGB
    print("written: own_scene.png,", " x ".join(str(side) for side in frame.image.shape))
    tracks = Tracks.concatenate(rows)
    scores = evaluate_sequence(episode.truth, tracks, len(episode))
    print(f"{len(set(episode.truth.ids.tolist()))} cars, HOTA {100 * scores['HOTA']:.1f}, ", end="")
    print(f"{scores['IDSW']:.0f} identity switches")

# Printed:
# written: own_scene.png, 375 x 1242 x 3
# 2 cars, HOTA 79.0, 0 identity switches

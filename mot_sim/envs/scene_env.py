"""A scene as a Gymnasium environment: it is watched through its detector, or driven in."""

from collections import OrderedDict
from copy import deepcopy
from typing import Any

import gymnasium as gym
from gymnasium import spaces
from jaxtyping import UInt8
from numpy import ndarray as Array

from mot_sim.envs.errors import OutOfTurn, require_action, require_options
from mot_sim.envs.factory import RENDER_MODES, find_long_scene, require_words, scaled
from mot_sim.envs.observing import Observation, ObservationBuilder
from mot_sim.envs.resuming import ReplayPickle
from mot_sim.envs.runs import LazyRollout, LiveRollout, driver_of
from mot_sim.envs.window import ImageWindow
from mot_sim.envs.wrappers import Scored, TrackObservation
from mot_sim.simulation.imaging import RenderedImages
from mot_sim.simulation.scene import Knob, Rollout
from mot_sim.simulation.traffic.driving import COMMANDS, driving_reward
from mot_sim.simulation.traffic.traffic_state import STEP
from tracker.types import Camera, Frame


class SceneEnv(ReplayPickle, gym.Env[Observation, Any]):
    """A scene at 10 Hz, to watch (traffic `recorded`) or to drive in (`live`).

    Observation: image (where `image`), boxes and scores of the detections with their mask,
    odometry (T_now_before; at first the identity), time. Action: of COMMANDS; recorded traffic
    cannot answer and knows `autopilot` (0) alone. Reward: `driving_reward`, of recorded traffic
    0. An episode is terminated when the ego car of live traffic crashes, and truncated at the
    last frame of the scene. info: `truth` (a FrameTruth), which is never observed, `frame`,
    `episode_seed`, from which all of the episode follows, and `crashed`.

    scale: of the image's sides. kept_runs: how many episodes of recorded traffic are kept with
    their labels, in case their seed comes again. knobs: of the scene. A pickled environment goes
    on where it was. Raises UnknownName and BadConfig.
    """

    # gym.make reads the class's; an instance has its own copy.
    metadata: dict[str, Any] = {  # noqa: RUF012
        "render_modes": list(RENDER_MODES), "render_fps": round(1.0 / STEP),
    }  # fmt: skip

    def __init__(
        self,
        scene: str = "crossing",
        *,
        traffic: str = "recorded",
        render_mode: str | None = None,
        image: bool = True,
        max_detections: int = 64,
        renderer: str = "raster",
        scale: float = 1.0,
        kept_runs: int = 2,
        **knobs: Knob,
    ) -> None:
        self._arguments = {
            "scene": scene, "traffic": traffic, "render_mode": render_mode, "image": image,
            "max_detections": max_detections, "renderer": renderer, "scale": scale,
            "kept_runs": kept_runs, **knobs,
        }  # fmt: skip
        require_words(traffic, render_mode, renderer, kept_runs)
        self.metadata = deepcopy(SceneEnv.metadata)
        self.render_mode = render_mode
        self.scene = scaled(find_long_scene(scene, knobs), scale)
        self.is_live = traffic == "live"
        if self.is_live:
            driver_of(self.scene, 0)
        self._watching = ObservationBuilder(
            self.camera, image, max_detections, self.scene.frame_count * STEP
        )
        self._renderer, self._kept = renderer, kept_runs
        self._runs: OrderedDict[int, LazyRollout] = OrderedDict()
        self._run: LazyRollout | None = None
        self._drawn: RenderedImages | None = None
        self._episode: int | None = None
        self._actions: list[Any] = []
        self._crashed = False
        self._picture: UInt8[Array, "h w 3"] | None = None
        self._window: ImageWindow | None = None
        self.observation_space = self._watching.space()
        self.action_space = spaces.Discrete(len(COMMANDS) if self.is_live else 1)

    @property
    def camera(self) -> Camera:
        """What sees the frames."""
        return self.scene.rig.camera

    @property
    def frame(self) -> Frame:
        """What a tracker may know of this moment. Raises OutOfTurn before the first reset."""
        image = self._image() if self._watching.image else None
        return self._now().frame(self._index, None if image is None else image.copy())

    @property
    def frame_count(self) -> int:
        """How many frames an episode has, the one after reset included."""
        return self.scene.frame_count

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """The first frame of a new episode.

        options: `episode_seed` plays the episode of that seed. Raises UnknownName for others.
        """
        super().reset(seed=seed)
        chosen = require_options(options, ("episode_seed",)).get("episode_seed")
        self._begin(int(self.np_random.integers(2**31) if chosen is None else chosen))
        return self._observe()

    def step(self, action: Any) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """The frame 0.1 s later. Raises OutOfTurn and BadAction."""
        self._now()
        if self._is_over:
            raise OutOfTurn(f"a step after the end, at frame {self._index}: call reset() first")
        named = COMMANDS[: int(self.action_space.n)]  # type: ignore[attr-defined]
        require_action(self.action_space, action, f"0 to {len(named) - 1} are {', '.join(named)}")
        self._advance(int(action))
        reward = driving_reward(self._rollout.driver.driving()) if self.is_live else 0.0
        observation, info = self._observe()
        return observation, reward, self._crashed, self._index + 1 >= self.frame_count, info

    def render(self) -> UInt8[Array, "h w 3"] | None:
        """The camera's picture; None where nobody asked for one, or where it goes to a window."""
        self._now()
        if self.render_mode == "human":
            self._show()
        return self._image().copy() if self.render_mode == "rgb_array" else None

    def close(self) -> None:
        """Close the window and forget all runs; `reset` begins anew."""
        if self._window is not None:
            self._window.close()
        self._window, self._run, self._episode = None, None, None
        self._drawn, self._picture = None, None
        self._runs.clear()

    @property
    def _index(self) -> int:
        return len(self._actions)

    @property
    def _is_over(self) -> bool:
        return self._crashed or self._index + 1 >= self.frame_count

    @property
    def _rollout(self) -> Any:
        return self._now().rollout

    def _now(self) -> LazyRollout:
        if self._run is None:
            raise OutOfTurn("nothing has begun: call reset() first")
        return self._run

    def _begin(self, episode: int) -> None:
        """Start the episode of a seed."""
        self._episode, self._actions, self._crashed = episode, [], False
        self._drawn, self._picture = None, None
        if self.is_live:
            self._run = LazyRollout(LiveRollout.begin(self.scene, episode))
            return
        self._run = self._runs.pop(episode, None) or LazyRollout(Rollout.of(self.scene, episode))
        self._runs[episode] = self._run
        while len(self._runs) > max(self._kept, 1):
            self._runs.popitem(last=False)

    def _advance(self, action: Any) -> None:
        """0.1 s of traffic."""
        if self.is_live:
            self._rollout.advance(COMMANDS[action])
            self._crashed = self._rollout.driver.driving().crashed
        self._actions.append(action)
        self._picture = None

    def _observe(self) -> tuple[Observation, dict[str, Any]]:
        """What is seen now, and what is true."""
        observation = self._watching.observe(self.frame)
        if self.render_mode == "human":
            self._show()
        told = {"frame": self._index, "episode_seed": self._episode, "crashed": self._crashed}
        return observation, {"truth": self._now().truth(self._index), **told}

    def _image(self) -> UInt8[Array, "h w 3"]:
        """The picture of this moment, drawn once."""
        if self._picture is None:
            if self._drawn is None:
                self._drawn = RenderedImages(self._rollout, self._renderer)
            picture = self._drawn.load(self._index)
            assert picture is not None
            self._picture = picture
        return self._picture

    def _show(self) -> None:
        if self._window is None:
            self._window = ImageWindow(f"mot-sim: {self.scene.name}", self.metadata["render_fps"])
        self._window.show(self._image())


__all__ = ["SceneEnv", "Scored", "TrackObservation"]

"""A scene as a Gymnasium environment: it is watched through its detector, or driven in."""

from collections import OrderedDict
from copy import deepcopy
from dataclasses import replace
from typing import Any

import gymnasium as gym
from gymnasium import spaces
from jaxtyping import UInt8
from numpy import ndarray as Array

from mot_sim.envs.driving_tasks import (
    ACTION_SPACES,
    META_ACTIONS,
    REWARDS,
    WATCH_ACTIONS,
    apply_action,
    copied,
    require_steerable,
)
from mot_sim.envs.errors import OutOfTurn, require_action, require_options
from mot_sim.envs.highway_env_config import refuse_config
from mot_sim.envs.image_window import (
    RENDER_MODES,
    ImageWindow,
    require_render_mode,
    warn_without_mode,
)
from mot_sim.envs.kinematics import kinematic_space, observe_kinematics
from mot_sim.envs.observations import ObservationBuilder, require_padding
from mot_sim.envs.rollouts import (
    LazyRollout,
    LiveRollout,
    ReplayPickle,
    driver_of,
    scene_made,
)
from mot_sim.envs.wrappers import Scored, TrackObservation
from mot_sim.simulation.imaging import RenderedImages
from mot_sim.simulation.registry import knobs_of
from mot_sim.simulation.renderers import AUTO, RENDERER_NAMES, RENDERERS
from mot_sim.simulation.rig import Rig
from mot_sim.simulation.scene import Knob, Rollout, Scene
from mot_sim.simulation.traffic.driving import Driven
from mot_sim.simulation.traffic.traffic_state import STEP_SECONDS
from tracker.errors import BadConfig, UnknownName
from tracker.types import Camera, Frame

TRAFFIC = ("recorded", "live")
OBSERVATIONS = ("detections", "kinematics")
MAX_OFF_ROAD_STEPS = 10  # 1 s; then the episode is truncated
OPTIONS = (
    "traffic", "actions", "observation", "max_vehicles", "reward", "render_mode", "image",
    "max_detections", "renderer", "scale", "kept_runs", "continuous",
)  # fmt: skip
SCALE_LIMITS = (0.1, 2.0)


class SceneEnv(ReplayPickle, gym.Env[Any, Any]):
    """A scene at 10 Hz, to watch (traffic `recorded`) or to drive in (`live`).

    Observation: image (where `image`), boxes and scores of the detections with their mask,
    odometry (T_now_before; at first the identity), time; or `kinematics` of live traffic, see
    `observe_kinematics`: nothing is sensed then. Action: of META_ACTIONS, or `continuous`:
    throttle and steering; recorded traffic cannot answer and knows `watch` (0) alone. Reward: of
    REWARDS; of recorded traffic 0. An episode is terminated when the ego car of live traffic
    crashes, and truncated at the last frame of the scene, where the road of the ego car ends, and
    once it has been off the road for 1 s. info: `truth` (a FrameTruth; not with kinematics),
    which is never observed, `frame`, `episode_seed`, from which all of the episode follows, and
    `crashed`.

    traffic: None: live where actions, kinematics or `continuous` are asked for, else recorded.
    actions: `meta` or `continuous`. max_vehicles: rows of the kinematics, the ego car's included.
    scale: of the image's sides. kept_runs: how many episodes of recorded traffic are kept with
    their labels, in case their seed comes again. continuous: where its road ends the ego car of
    live traffic begins a new way elsewhere; its motion to there is not known. knobs: of the
    scene. A pickled environment goes on where it was. Raises UnknownName and BadConfig.
    """

    # gym.make reads the class's; an instance has its own copy.
    metadata: dict[str, Any] = {  # noqa: RUF012
        "render_modes": list(RENDER_MODES),
        "render_fps": round(1.0 / STEP_SECONDS),
    }

    def __init__(
        self,
        scene: str = "crossing",
        *,
        traffic: str | None = None,
        actions: str | None = None,
        observation: str = "detections",
        max_vehicles: int = 5,
        reward: str = "progress",
        render_mode: str | None = None,
        image: bool = True,
        max_detections: int = 64,
        renderer: str = "raster",
        scale: float = 1.0,
        kept_runs: int = 2,
        continuous: bool = False,
        **knobs: Knob,
    ) -> None:
        self._arguments = {
            "scene": scene,
            "traffic": traffic,
            "actions": actions,
            "observation": observation,
            "max_vehicles": max_vehicles,
            "reward": reward,
            "render_mode": render_mode,
            "image": image,
            "max_detections": max_detections,
            "renderer": renderer,
            "scale": scale,
            "kept_runs": kept_runs,
            "continuous": continuous,
            **knobs,
        }
        is_live = require_words(traffic, actions, observation, continuous)
        require_render_mode(render_mode)
        require_more(renderer, reward, kept_runs, max_vehicles)
        self.metadata = deepcopy(SceneEnv.metadata)
        self.render_mode = render_mode
        self.scene = scaled(find_long_scene(scene, knobs), scale)
        self.is_live, self._continuous = is_live, continuous
        self._actions_kind = (actions or "meta") if is_live else None
        if is_live:
            self._driver(0)
        self._is_kinematic, self._max_vehicles = observation == "kinematics", max_vehicles
        self._reward = REWARDS[reward]
        self._observations = ObservationBuilder(
            self.camera,
            image and not self._is_kinematic,
            max_detections,
            self.scene.frame_count * STEP_SECONDS,
        )
        self._renderer, self._kept = renderer, kept_runs
        self._rollouts: OrderedDict[int, LazyRollout] = OrderedDict()
        self._current: LazyRollout | None = None
        self._images: RenderedImages | None = None
        self._episode: int | None = None
        self._actions: list[Any] = []
        self._crashed, self._off_road = False, 0
        self._image: UInt8[Array, "h w 3"] | None = None
        self._window: ImageWindow | None = None
        seen: spaces.Space[Any] = self._observations.space()
        self.observation_space = kinematic_space(max_vehicles) if self._is_kinematic else seen
        self.action_space = (
            spaces.Discrete(len(WATCH_ACTIONS))
            if self._actions_kind is None
            else ACTION_SPACES[self._actions_kind]()
        )

    @property
    def camera(self) -> Camera:
        """The scene's, scaled."""
        return self.scene.rig.camera

    @property
    def frame(self) -> Frame:
        """What a tracker may know of this moment. Raises OutOfTurn before the first reset."""
        image = self._draw() if self._observations.image else None
        return self._now().frame(self._index, None if image is None else image.copy())

    @property
    def frame_count(self) -> int:
        """How many frames an episode has at most, the one after reset included."""
        return self.scene.frame_count

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """The first frame of a new episode.

        options: `episode_seed` plays the episode of that seed. Raises UnknownName for others.
        """
        super().reset(seed=seed)
        chosen = require_options(options, ("episode_seed",)).get("episode_seed")
        self._begin(int(self.np_random.integers(2**31) if chosen is None else chosen))
        return self._observe()

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """The frame 0.1 s later. Raises OutOfTurn and BadAction."""
        self._now()
        if self._is_over:
            raise OutOfTurn(f"a step after the end, at frame {self._index}: call reset() first")
        require_action(self.action_space, action, self._meaning)
        self._advance(copied(action))
        reward = self._reward(self._rollout.driver.driving()) if self.is_live else 0.0
        observation, info = self._observe()
        return observation, reward, self._crashed, self._is_at_end, info

    def render(self) -> UInt8[Array, "h w 3"] | None:
        """The camera's image; None in a window, and, with a warning, without a render mode."""
        self._now()
        warn_without_mode(self.render_mode)
        if self.render_mode == "human":
            self._show()
        return self._draw().copy() if self.render_mode == "rgb_array" else None

    def close(self) -> None:
        """Close the window and forget all rollouts; `reset` begins anew."""
        if self._window is not None:
            self._window.close()
        self._window, self._current, self._episode = None, None, None
        self._images, self._image = None, None
        self._rollouts.clear()

    @property
    def _meaning(self) -> str:
        """What the actions are, for who gives others."""
        if self._actions_kind == "continuous":
            return "give throttle and steering, two float32 from -1 to 1"
        named = META_ACTIONS if self.is_live else WATCH_ACTIONS
        return f"0 to {len(named) - 1} are {', '.join(named)}" if self.is_live else "0 is watch"

    @property
    def _index(self) -> int:
        return len(self._actions)

    @property
    def _is_over(self) -> bool:
        return self._crashed or self._is_at_end

    @property
    def _is_at_end(self) -> bool:
        """Whether this is the last frame, or the ego car's road has ended."""
        if self.is_live and (
            self._rollout.driver.has_ended or self._off_road >= MAX_OFF_ROAD_STEPS
        ):
            return True
        return self._index + 1 >= (self.frame_count if self.is_live else len(self._rollout))

    @property
    def _rollout(self) -> Any:
        return self._now().rollout

    def _now(self) -> LazyRollout:
        if self._current is None:
            raise OutOfTurn("nothing has begun: call reset() first")
        return self._current

    def _begin(self, episode: int) -> None:
        """Start the episode of a seed."""
        self._episode, self._actions, self._crashed, self._off_road = episode, [], False, 0
        self._images, self._image = None, None
        if self.is_live:
            driver = self._driver(episode)
            live = LiveRollout.begin(self.scene, episode, driver, self._continuous)
            self._current = LazyRollout(live)
            return
        self._current = self._rollouts.pop(episode, None) or LazyRollout(
            Rollout.of(self.scene, episode)
        )
        self._rollouts[episode] = self._current
        while len(self._rollouts) > max(self._kept, 1):
            self._rollouts.popitem(last=False)

    def _advance(self, action: Any) -> None:
        """0.1 s of traffic."""
        if self.is_live:
            apply_action(self._rollout.driver, action)
            self._rollout.advance()
            driving = self._rollout.driver.driving()
            self._crashed = driving.crashed
            # Past the end of its road it waits for room to begin a new way: it did not leave one.
            is_right = driving.on_road or (self._continuous and driving.road_ended)
            self._off_road = 0 if is_right else self._off_road + 1
        self._actions.append(action)
        self._image = None

    def _observe(self) -> tuple[Any, dict[str, Any]]:
        """The observation of this moment, and the info."""
        if self.render_mode == "human":
            self._show()
        info = {"frame": self._index, "episode_seed": self._episode, "crashed": self._crashed}
        if self._is_kinematic:
            state, speed = (
                self._rollout.traffic_states[self._index],
                self._rollout.driver.driving().speed,
            )
            return observe_kinematics(state, speed, self._max_vehicles), info
        observation = self._observations.observe(self.frame)
        return observation, {"truth": self._now().truth(self._index), **info}

    def _driver(self, episode: int) -> Driven:
        """The traffic of an episode, which takes the actions of this environment."""
        driver = driver_of(self.scene, episode)
        is_steered = self._actions_kind == "continuous"
        return require_steerable(self.scene.name, driver) if is_steered else driver

    def _draw(self) -> UInt8[Array, "h w 3"]:
        """The image of this moment, rendered once."""
        if self._image is None:
            if self._images is None:
                self._images = RenderedImages(self._rollout, self._renderer)
            image = self._images.load(self._index)
            assert image is not None
            self._image = image
        return self._image

    def _show(self) -> None:
        if self._window is None:
            self._window = ImageWindow(f"mot-sim: {self.scene.name}", self.metadata["render_fps"])
        self._window.show(self._draw())


def require_words(
    traffic: str | None, actions: str | None, observation: str, continuous: bool
) -> bool:
    """Whether traffic is live. Raises UnknownName, BadConfig for what recorded traffic lacks."""
    for what, word, known in (
        ("traffic", traffic, TRAFFIC),
        ("actions", actions, ACTION_SPACES),
        ("observation", observation, OBSERVATIONS),
    ):
        if word is not None and word not in known:
            raise UnknownName.of(what, str(word), known)
    asked = {
        f"actions={actions!r}": actions is not None,
        "observation='kinematics'": observation == "kinematics",
        "continuous=True": continuous,
    }
    wanted = [option for option, is_asked in asked.items() if is_asked]
    if traffic == "recorded" and wanted:
        raise BadConfig(f"{wanted[0]} is for traffic='live': recorded traffic cannot answer")
    return traffic == "live" or bool(wanted)


def require_more(renderer: str, reward: str, kept_runs: int, max_vehicles: int) -> None:
    """Raises UnknownName for words that are none, BadConfig for numbers out of range."""
    if renderer != AUTO and renderer not in RENDERER_NAMES:
        raise UnknownName.of("renderer", renderer, (*RENDERERS, AUTO))
    if reward not in REWARDS:
        raise UnknownName.of("reward", reward, REWARDS)
    if kept_runs < 0:
        raise BadConfig(f"kept_runs is {kept_runs}: give 0 or more")
    require_padding("max_vehicles", max_vehicles)


def find_long_scene(name: str, knobs: dict[str, Knob]) -> Scene:
    """The scene of a name and its knobs, two or more frames long."""
    known = knobs_of(name)
    if "config" in knobs:
        refuse_config(knobs["config"], name, known)
    for knob in knobs:
        if knob not in known:
            raise UnknownName.of(f"option or knob of scene {name}:", knob, (*OPTIONS, *known))
    frames = knobs.get("frames", known.get("frames"))
    if type(frames) is int and frames < 2:
        raise BadConfig(f"frames of scene {name} is {frames}: an environment needs 2 or more")
    return scene_made(name, tuple(sorted(knobs.items())))


def scaled(scene: Scene, scale: float) -> Scene:
    """The scene with a camera of fewer or more pixels, and the same view."""
    if not SCALE_LIMITS[0] <= scale <= SCALE_LIMITS[1]:
        raise BadConfig(f"scale is {scale:g}: give {SCALE_LIMITS[0]:g} to {SCALE_LIMITS[1]:g}")
    if scale == 1.0:
        return scene
    camera = scene.rig.camera
    K = camera.K.copy()
    K[:2, :2] *= scale
    K[:2, 2] = (K[:2, 2] + 0.5) * scale - 0.5  # pixel centres are at integers
    width, height = (round(scale * side) for side in camera.image_size)
    return replace(scene, rig=Rig(Camera(K, (width, height), camera.T_cam_road)))


__all__ = ["SceneEnv", "Scored", "TrackObservation"]

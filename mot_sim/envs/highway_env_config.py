"""highway-env's `config`, answered with the keywords that do the same here."""

from collections.abc import Callable, Collection, Mapping
from typing import Any

from mot_sim.simulation.traffic.traffic_state import STEP_SECONDS
from tracker.errors import BadConfig, UnknownName

Answer = str | Callable[[Any], str]
FIXED_RATE = "a step is always 0.1 s"
NOT_HERE = "there is no such thing here"
SCALE = "scale=0.5 halves the image's sides"
REWARD = "reward='progress' or reward='highway_env'"


def _typed(known: Mapping[str, str]) -> Answer:
    """The keyword for a nested config, by its `type`."""

    def answer(value: Any) -> str:
        kind = value.get("type") if isinstance(value, Mapping) else value
        return known.get(str(kind), f"{' or '.join(known.values())}; there is no {kind!r}")

    return answer


def _frames(value: Any) -> str:
    if isinstance(value, int | float):
        return f"frames={round(value / STEP_SECONDS) + 1} for {value:g} s"
    return "frames=, 10 a second"


ANSWERS: dict[str, Answer] = {
    "observation": _typed({"Kinematics": "observation='kinematics'", "detections": "image=False"}),
    "action": _typed(
        {"DiscreteMetaAction": "actions='meta'", "ContinuousAction": "actions='continuous'"}
    ),
    "vehicles_count": lambda value: f"cars={value}",
    "initial_vehicle_count": lambda value: f"cars={value}",
    "vehicles_density": "cars=, how many",
    "spawn_probability": "arrivals=, cars a second",
    "duration": _frames,
    "simulation_frequency": FIXED_RATE,
    "policy_frequency": FIXED_RATE,
    "screen_width": SCALE,
    "screen_height": SCALE,
    "scaling": SCALE,
    "centering_position": NOT_HERE,
    "show_trajectories": NOT_HERE,
    "render_agent": NOT_HERE,
    "manual_control": NOT_HERE,
    "other_vehicles_type": NOT_HERE,
    "neighbour_vehicles_connected_lanes": NOT_HERE,
    "controlled_vehicles": NOT_HERE,
    "ego_spacing": NOT_HERE,
    "initial_lane_id": NOT_HERE,
    "lanes_count": "another scene: mot-sim list names them",
    "destination": "route=, where the scene has that knob",
    "offscreen_rendering": "render_mode='rgb_array' or render_mode='human'",
    "real_time_rendering": "render_mode='human'",
    "collision_reward": REWARD,
    "high_speed_reward": REWARD,
    "right_lane_reward": REWARD,
    "lane_change_reward": REWARD,
    "arrived_reward": REWARD,
    "reward_speed_range": REWARD,
    "normalize_reward": REWARD,
    "offroad_terminal": "an episode is always truncated off the road",
}


def refuse_config(config: Any, scene: str, knobs: Collection[str]) -> None:
    """Raises BadConfig with the keywords for highway-env's keys, UnknownName for other keys.

    scene: its name. knobs: what it knows.
    """
    if not isinstance(config, Mapping):
        raise BadConfig(
            f"config={config!r}: options are keywords here, as in gym.make(id, frames=100)"
        )
    answers = []
    for key, value in config.items():
        if key not in ANSWERS:
            raise UnknownName.of("key of highway-env's config", str(key), ANSWERS)
        found = ANSWERS[key]
        answer = found if isinstance(found, str) else found(value)
        keyword, is_keyword, _ = answer.partition("=")
        if is_keyword and keyword in ("cars", "arrivals", "route") and keyword not in knobs:
            answer = f"{NOT_HERE}: scene {scene} has no knob {keyword}"
        answers.append(f"{key}: {answer}")
    raise BadConfig(
        "config is highway-env's; options are keywords of gym.make here. "
        + "; ".join(answers or ["drop the empty config"])
    )

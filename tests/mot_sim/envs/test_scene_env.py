"""A scene as a Gymnasium environment."""

import gymnasium as gym
import numpy as np
import pytest

from mot_sim.envs.driving_tasks import META_ACTIONS, progress_reward
from mot_sim.envs.errors import BadAction, OutOfTurn
from mot_sim.envs.kinematics import observe_kinematics
from mot_sim.envs.observations import ObservationBuilder, surest
from mot_sim.envs.rollouts import FrameTruth, LazyRollout, same
from mot_sim.envs.scene_env import SceneEnv
from mot_sim.simulation.episode import record
from mot_sim.simulation.imaging import RenderedImages
from mot_sim.simulation.registry import find_scene
from mot_sim.simulation.scene import Rollout
from mot_sim.simulation.traffic.driving import Driving, driving_reward
from mot_sim.simulation.traffic.traffic_state import TrafficState
from tracker.errors import BadConfig, UnknownName
from tracker.types import Detections

FRAMES = 20
AUTOPILOT = META_ACTIONS.index("autopilot")
SPARSE = {"cars": 4, "arrivals": 0.0, "frames": 6}


@pytest.fixture(scope="module")
def env() -> SceneEnv:
    return SceneEnv("crossing", frames=FRAMES, image=False)


def test_frames_and_truth_are_those_of_the_recorded_episode(env) -> None:
    episode = record(find_scene("crossing", frames=FRAMES), seed=7)
    frames = list(episode)
    _, told = env.reset(options={"episode_seed": 7})
    for index, frame in enumerate(frames):
        assert env.frame.index == index
        assert env.frame.time == pytest.approx(frame.time)
        np.testing.assert_array_equal(env.frame.detections.boxes, frame.detections.boxes)
        np.testing.assert_array_equal(env.frame.detections.scores, frame.detections.scores)
        if frame.T_now_before is not None:
            np.testing.assert_allclose(env.frame.T_now_before, frame.T_now_before, atol=1e-12)
        rows = episode.truth.frames == index
        np.testing.assert_array_equal(told["truth"].labels.ids, episode.truth.ids[rows])
        np.testing.assert_array_equal(told["truth"].labels.boxes, episode.truth.boxes[rows])
        if index + 1 < FRAMES:
            observation, reward, terminated, truncated, told = env.step(0)
            assert (reward, terminated, truncated) == (0.0, False, index + 2 == FRAMES)
            assert observation["time"] == pytest.approx(0.1 * (index + 1))


def test_an_episode_that_comes_again_is_not_labelled_again(env) -> None:
    env.reset(options={"episode_seed": 3})
    run = env._now()
    env.reset(options={"episode_seed": 4})
    env.reset(options={"episode_seed": 3})
    assert env._now() is run


def test_labels_wait_until_they_are_asked_for() -> None:
    run = LazyRollout(Rollout.of(find_scene("crossing", frames=40), 0))
    assert run.annotations == {}
    run.frame(0)
    assert len(run.annotations) == 1
    run.truth(1)
    run.truth(2)
    assert len(run.annotations) == 4
    run.truth(39)
    assert len(run.annotations) == 40
    at_once = LazyRollout(run.rollout)
    at_once.truth(39)
    for frame in range(40):  # in whatever blocks, a frame is the same
        assert at_once.truth(frame) == run.truth(frame)
        assert same(at_once.detections[frame], run.detections[frame])


def test_what_is_observed_is_the_callers_own(env) -> None:
    observation, _ = env.reset(options={"episode_seed": 3})
    kept = {name: part.copy() for name, part in observation.items()}
    for part in observation.values():
        part[...] = 0
    again, _ = env.reset(options={"episode_seed": 3})
    for name, part in again.items():
        np.testing.assert_array_equal(part, kept[name])


def test_the_picture_is_the_renderers_and_drawn_when_asked_for() -> None:
    env = SceneEnv("crossing", frames=3, scale=0.25, render_mode="rgb_array", houses=0.0, trees=0.0)
    observation, _ = env.reset(options={"episode_seed": 1})
    picture = env.render()
    expected = RenderedImages(Rollout.of(env.scene, 1)).load(0)
    np.testing.assert_array_equal(picture, expected)
    np.testing.assert_array_equal(observation["image"], expected)
    picture[...] = 0
    np.testing.assert_array_equal(env.render(), expected)
    assert picture.shape == (94, 310, 3)
    env.step(0)
    assert (env.render() != expected).any()
    assert SceneEnv("crossing", image=False).render_mode is None


def test_a_film_is_recorded_where_moviepy_is_installed(tmp_path) -> None:
    pytest.importorskip("moviepy")
    env = gym.make("mot_sim/Crossing-v0", frames=4, scale=0.2, render_mode="rgb_array")
    film = gym.wrappers.RecordVideo(env, str(tmp_path))
    film.reset(seed=0)
    for _ in range(3):
        film.step(0)
    film.close()
    assert list(tmp_path.glob("*.mp4"))


def test_a_window_is_opened_for_people_and_closed_again(monkeypatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    env = SceneEnv("crossing", frames=3, scale=0.2, image=False, render_mode="human")
    env.reset(seed=0)
    assert env.render() is None
    assert env._window is not None
    env.close()
    assert env._window is None


def test_a_smaller_image_shows_the_same_view() -> None:
    whole, half = SceneEnv("crossing").camera, SceneEnv("crossing", scale=0.5).camera
    assert half.image_size == (621, 188)
    point = np.array([[1.0, 1.0, 20.0]])
    np.testing.assert_allclose(
        half.project(point) + 0.5, 0.5 * (whole.project(point) + 0.5), atol=1e-9
    )


def test_no_detections_are_observed_as_none() -> None:
    watching = ObservationBuilder(SceneEnv("crossing").camera, False, 4, 1.0)
    empty = LazyRollout(Rollout.of(find_scene("crossing", frames=2), 0)).frame(0)
    observation = watching.observe(type(empty)(0, 0.0, Detections.empty()))
    assert observation["mask"].sum() == 0
    assert observation in watching.space()


def test_of_too_many_detections_the_surest_are_observed_in_their_order() -> None:
    boxes = np.arange(12.0).reshape(3, 4)
    kept = surest(Detections(boxes, np.array([0.3, 0.9, 0.5])), 2)
    assert kept.scores.tolist() == [0.9, 0.5]
    assert surest(kept, 2) is kept


def test_truth_is_equal_only_where_everything_is(env) -> None:
    _, one = env.reset(options={"episode_seed": 3})
    _, same = env.reset(options={"episode_seed": 3})
    other = env.step(0)[4]
    assert isinstance(one["truth"], FrameTruth)
    assert one["truth"] == same["truth"]
    assert one["truth"] != other["truth"]
    assert one["truth"] != "truth"


@pytest.mark.parametrize(
    ("options", "error", "told"),
    [
        ({"scene": "crosing"}, UnknownName, "Did you mean 'crossing'"),
        ({"traffic": "lively"}, UnknownName, "unknown traffic 'lively'.*Did you mean 'live'"),
        ({"renderer": "rastor"}, UnknownName, "Did you mean 'raster'"),
        ({"render_mode": "ansi"}, UnknownName, "unknown render mode 'ansi'"),
        ({"imgae": True}, UnknownName, "unknown option or knob.*Did you mean 'image'"),
        ({"frames": 1}, BadConfig, "frames of scene crossing is 1"),
        ({"frames": "many"}, BadConfig, "frames"),
        ({"max_detections": 0}, BadConfig, "max_detections is 0"),
        ({"scale": 0.0}, BadConfig, "scale is 0"),
        ({"kept_runs": -1}, BadConfig, "kept_runs is -1"),
        ({"traffic": "live"}, BadConfig, "crossing has no live traffic"),
        ({"actions": "continuous"}, BadConfig, "crossing has no live traffic"),
        ({"actions": "meat"}, UnknownName, "Did you mean 'meta'"),
        ({"traffic": "recorded", "actions": "meta"}, BadConfig, "actions='meta' is for traffic='l"),
        ({"observation": "kinematic"}, UnknownName, "Did you mean 'kinematics'"),
        ({"max_vehicles": 0}, BadConfig, "max_vehicles is 0"),
        ({"reward": "progres"}, UnknownName, "Did you mean 'progress'"),
        ({"scene": "highway", "cars": -2}, BadConfig, "cars"),
    ],
)
def test_wrong_options_are_refused_at_once(options, error, told) -> None:
    with pytest.raises(error, match=told):
        SceneEnv(**options)


def test_wrong_uses_are_refused(env) -> None:
    with pytest.raises(UnknownName, match=r"option of reset 'seed'.*episode_seed"):
        env.reset(options={"seed": 3})
    env.close()
    for use in (lambda: env.frame, env.render, lambda: env.step(0)):
        with pytest.raises(OutOfTurn, match=r"call reset\(\) first"):
            use()
    env.reset(options={"episode_seed": 3})
    with pytest.raises(BadAction, match=r"action 1 is not in Discrete\(1\): 0 is watch"):
        env.step(1)


@pytest.fixture
def live() -> SceneEnv:
    return SceneEnv("highway", traffic="live", image=False, **{**SPARSE, "frames": 30})


def test_under_autopilot_live_traffic_does_what_was_recorded(live) -> None:
    recorded = SceneEnv("highway", image=False, **{**SPARSE, "frames": 30})
    one, told = live.reset(options={"episode_seed": 5})
    other, was_told = recorded.reset(options={"episode_seed": 5})
    for _ in range(12):
        np.testing.assert_array_equal(
            told["truth"].traffic_state.x, was_told["truth"].traffic_state.x
        )
        np.testing.assert_array_equal(
            told["truth"].traffic_state.ego, was_told["truth"].traffic_state.ego
        )
        assert told["truth"] == was_told["truth"]
        np.testing.assert_array_equal(one["boxes"], other["boxes"])
        one, *_, told = live.step(AUTOPILOT)
        other, *_, was_told = recorded.step(0)


def drive(env: SceneEnv, command: str, steps: int) -> list[Driving]:
    env.reset(options={"episode_seed": 5})
    seen = []
    for _ in range(steps):
        _, reward, *_ = env.step(META_ACTIONS.index(command))
        seen.append(env._rollout.driver.driving())
        assert reward == progress_reward(seen[-1])
    return seen


def test_the_ego_car_obeys(live) -> None:
    live.reset(options={"episode_seed": 5})
    begin = live._rollout.driver.driving()
    slower, faster = drive(live, "slower", 20), drive(live, "faster", 20)
    assert slower[-1].speed < begin.speed - 5.0
    assert faster[-1].speed > begin.speed + 5.0
    held = drive(live, "idle", 20)
    assert held[-1].speed == pytest.approx(begin.speed, abs=0.1)
    aside = "lane_left" if begin.lane else "lane_right"
    changed = drive(live, aside, 29)
    assert changed[-1].lane != begin.lane
    assert 0 <= changed[-1].lane < changed[-1].lanes


def test_cars_that_come_later_are_cast_as_if_they_had_always_been_known() -> None:
    options = {"image": False, "cars": 4, "arrivals": 3.0, "frames": 40}
    live = SceneEnv("highway", traffic="live", **options)
    recorded = SceneEnv("highway", **options)
    live.reset(options={"episode_seed": 2})
    recorded.reset(options={"episode_seed": 2})
    before = len(live._rollout.scene_meshes.vehicles)
    for _ in range(39):
        live._advance(AUTOPILOT)
    cast, whole = live._rollout.scene_meshes.vehicles, recorded._rollout.scene_meshes.vehicles
    assert len(cast) > before
    np.testing.assert_array_equal(cast.ids, whole.ids)
    np.testing.assert_array_equal(cast.paints, whole.paints)
    np.testing.assert_array_equal(cast.size, whole.size)


@pytest.mark.parametrize(
    ("driving", "reward"),
    [
        (Driving(30.0, 30.0, 2, 3, True, False), 1.0),
        (Driving(25.0, 30.0, 0, 3, True, False), 1.2 / 1.5),
        (Driving(20.0, 30.0, 1, 3, True, False), 1.05 / 1.5),
        (Driving(9.0, 30.0, 0, 1, True, True), 0.0),
        (Driving(30.0, 30.0, 2, 3, False, False), 0.0),
    ],
)
def test_the_reward_is_highway_envs(driving, reward) -> None:
    assert driving_reward(driving) == pytest.approx(reward)


def test_a_crash_ends_a_live_episode() -> None:
    env = SceneEnv("look_alikes", traffic="live", image=False, frames=150)
    env.reset(seed=0)
    terminated = truncated = False
    while not (terminated or truncated):
        _, reward, terminated, truncated, told = env.step(META_ACTIONS.index("faster"))
    assert terminated
    assert told["crashed"]
    assert reward == -1.0
    with pytest.raises(OutOfTurn, match="after the end"):
        env.step(AUTOPILOT)


def test_live_traffic_is_drawn_frame_after_frame() -> None:
    env = SceneEnv("highway", traffic="live", scale=0.1, **SPARSE)
    first, _ = env.reset(options={"episode_seed": 0})
    later = [env.step(AUTOPILOT)[0]["image"] for _ in range(3)]
    assert all(image.shape == first["image"].shape for image in later)
    assert (later[-1] != first["image"]).any()


def test_an_episode_ends_with_the_road_or_goes_on_with_flat_memory() -> None:
    knobs = {"cars": 0, "arrivals": 0.0, "parked": 0.0, "vans": 0, "frames": 200, "bends": False}
    plain = {"houses": 0.0, "trees": 0.0, "furniture": 0.0}
    found = {}
    for continuous in (False, True):
        env = SceneEnv(
            "street", traffic="live", image=False, continuous=continuous, **knobs, **plain
        )
        env.reset(options={"episode_seed": 0})
        unknown = 0
        for _ in range(160):
            _, _, terminated, truncated, told = env.step(META_ACTIONS.index("faster"))
            unknown += env.frame.T_now_before is None
            if truncated:
                break
        found[continuous] = terminated, truncated, unknown, env._now()
    assert found[False][:3] == (False, True, 0)
    assert found[True][:3] == (False, False, 1)
    assert told["frame"] == 160
    assert len(found[True][3].annotations) == 1
    with pytest.raises(IndexError, match="kept are 159 to 160"):
        found[True][3].rollout.traffic_states[3]
    with pytest.raises(BadConfig, match="continuous=True is for traffic='live'"):
        SceneEnv("street", traffic="recorded", continuous=True)


def test_who_waits_for_room_to_begin_a_new_way_has_not_left_the_road(monkeypatch) -> None:
    plain = {"houses": 0.0, "trees": 0.0, "furniture": 0.0}
    env = SceneEnv("highway", image=False, continuous=True, frames=200, **plain)
    env.reset(options={"episode_seed": 0})
    past = Driving(20.0, 30.0, 0, 3, on_road=False, crashed=False, road_ended=True)
    monkeypatch.setattr(type(env._rollout.driver), "driving", lambda _: past)
    ends = [env.step(AUTOPILOT)[3] for _ in range(15)]
    assert not any(ends)
    aside = Driving(20.0, 30.0, 0, 3, on_road=False, crashed=False)
    monkeypatch.setattr(type(env._rollout.driver), "driving", lambda _: aside)
    assert [env.step(AUTOPILOT)[3] for _ in range(10)] == [False] * 9 + [True]


def test_actions_stand_in_the_order_of_highway_env() -> None:
    from highway_env.envs.common.action import DiscreteMetaAction

    theirs = [name.lower() for _, name in sorted(DiscreteMetaAction.ACTIONS_ALL.items())]
    assert [*theirs, "autopilot"] == list(META_ACTIONS)


def test_an_action_makes_traffic_live() -> None:
    assert not SceneEnv("highway", **SPARSE).is_live
    for asked in ({"actions": "meta"}, {"observation": "kinematics"}, {"continuous": True}):
        env = SceneEnv("highway", **asked, **SPARSE)
        assert env.is_live
        assert env.action_space.n == len(META_ACTIONS)


def test_the_ego_car_is_steered_off_the_road_and_the_episode_truncated() -> None:
    env = SceneEnv("highway", actions="continuous", image=False, cars=0, arrivals=0.0, frames=200)
    env.reset(seed=0)
    begin = env._rollout.driver.driving().speed
    for _ in range(5):
        *_, told = env.step(np.array([-1.0, 0.0], np.float32))
    assert env._rollout.driver.driving().speed == pytest.approx(begin - 5.0 * 0.5, abs=1e-6)
    rewards, truncated, terminated = [], False, False
    while not (truncated or terminated):
        _, reward, terminated, truncated, told = env.step(np.array([0.0, 0.1], np.float32))
        rewards.append(reward)
    assert (terminated, truncated) == (False, True)
    assert told["frame"] < 100
    assert rewards[0] > 0.5
    assert rewards[-10:] == [0.0] * 10
    for wrong in (1, np.zeros(3, np.float32), np.array([2.0, 0.0], np.float32), "left"):
        with pytest.raises(BadAction, match="give throttle and steering"):
            SceneEnv.step(started(env), wrong)


def started(env: SceneEnv) -> SceneEnv:
    env.reset(seed=0)
    return env


def test_kinematics_by_hand() -> None:
    at = np.array([0.0, 0.0, 0.0, 1.0, 500.0])
    state = TrafficState(
        time=0.0, ids=np.arange(5), x=np.array([30.0, 20.0, -50.0, 12.0, 400.0]), y=at,
        heading=np.array([0.0, np.pi, 0.0, 0.0, 0.0]), speed=np.array([20.0, 8.0, 9.0, 10.0, 1.0]),
        size=np.ones((5, 3)), ego=np.array([10.0, 0.0, 0.0]), ego_size=np.ones(3),
    )  # fmt: skip
    seen = observe_kinematics(state, 16.0, 4)
    expected = [
        [1.0, 0.05, 0.0, 0.2, 0.0],
        [1.0, 0.01, 0.005, -0.075, 0.0],
        [1.0, 0.05, 0.0, -0.3, 0.0],
        [1.0, 0.1, 0.0, 0.05, 0.0],
    ]
    np.testing.assert_allclose(seen, expected, atol=1e-6)
    assert not observe_kinematics(state, 16.0, 6)[4:].any()
    env = SceneEnv("highway", observation="kinematics", **SPARSE)
    observation, told = env.reset(seed=0)
    assert observation in env.observation_space
    assert observation[0, 0] == 1.0
    assert "truth" not in told


@pytest.mark.parametrize(
    ("driving", "reward"),
    [
        (Driving(15.0, 30.0, 0, 3, True, False), 0.5),
        (Driving(40.0, 30.0, 0, 3, True, False), 1.0),
        (Driving(0.0, 30.0, 0, 3, True, False), 0.0),
        (Driving(-9.0, 30.0, 0, 1, True, False), 0.0),
        (Driving(30.0, 30.0, 2, 3, False, False), 0.0),
        (Driving(30.0, 30.0, 2, 3, True, True), -1.0),
    ],
)
def test_progress_is_paid(driving, reward) -> None:
    assert progress_reward(driving) == reward


@pytest.mark.parametrize(
    ("config", "error", "told"),
    [
        ({"vehicles_count": 20}, BadConfig, "vehicles_count: cars=20"),
        ({"duration": 40}, BadConfig, "frames=401 for 40 s"),
        ({"action": {"type": "ContinuousAction"}}, BadConfig, "actions='continuous'"),
        ({"observation": {"type": "Kinematics"}}, BadConfig, "observation='kinematics'"),
        ({"vehicle_count": 3}, UnknownName, "Did you mean 'vehicles_count'"),
        ({}, BadConfig, "drop the empty config"),
        (3, BadConfig, "options are keywords"),
    ],
)
def test_a_config_is_answered_with_keywords(config, error, told) -> None:
    with pytest.raises(error, match=told):
        SceneEnv("highway", config=config)

"""Groups of options that several commands share. Values are checked by what uses them."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from math import radians
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

if TYPE_CHECKING:
    import mot_sim.datasets
    import mot_sim.evaluation.run_folder
    import mot_sim.evaluation.runs
    import mot_sim.experiments.sweep
    import mot_sim.files.settings
    import mot_sim.foreign.isolation
    import mot_sim.simulation.scene

DETECTIONS, EGO, SPLIT = "rrc", "oxts", "training"
ISOLATION = "mot_sim.foreign.isolation"
CAMERA_HEIGHT = 1.65  # metres; KITTI's car, as in mot_sim.datasets.kitti (which imports slowly)


def option(metavar: str, default: str = "", **more: object) -> object:
    """How `--help` shows an option whose default is not a plain value."""
    hint = f"(default: {default})" if default else "(optional)"
    return tyro.conf.arg(metavar=metavar, help_behavior_hint=hint, **more)  # type: ignore[call-overload]


def help_of(module: str, kind: str, field: str) -> Callable[[], str]:
    """For `option(help=...)`: what stands under the field of a class, for options that hand it on.

    The text is read when --help shows it, and the module is not imported.
    """

    def read() -> str:
        from mot_sim.files.field_docstrings import field_docstring_in

        return field_docstring_in(module, kind, field)

    return read


Verbose = Annotated[tyro.conf.UseCounterAction[int], option("", "warnings only", aliases=("-v",))]
Root = Annotated[Path | None, option("DIR", "$MOT_SIM_KITTI_ROOT")]
Rules = Annotated[str, option("NAME", "trackeval")]
Classes = Annotated[str, option("NAMES", "car")]
Flag = Annotated[bool, tyro.conf.arg(help_behavior_hint="")]
File = Annotated[str | None, option("FILE|-")]
Jobs = Annotated[
    int, option("N", "1", help=help_of("mot_sim.experiments.executor", "Executor", "jobs"))
]


@dataclass(frozen=True)
class IsolationOptions:
    """Where trackers run, and what they may take there."""

    isolate: Flag = False
    """Run every tracker in a process of its own; those that are not ours run in one anyway."""
    no_isolate: Flag = False
    """Run all trackers in the process that asks them: one that hangs or ends it takes all along."""
    time_limit: Annotated[
        float, option("SECONDS", "60", help=help_of(ISOLATION, "Isolation", "time_limit"))
    ] = 60.0
    memory_limit: Annotated[
        float, option("MB", "4096", help=help_of(ISOLATION, "Isolation", "memory_limit"))
    ] = 4096.0

    def read(self) -> "mot_sim.foreign.isolation.Isolation":
        """What the options say. Raises BadConfig for limits that cannot be."""
        from mot_sim.foreign.isolation import Isolation
        from tracker.errors import BadConfig

        if self.isolate and self.no_isolate:
            raise BadConfig("--isolate and --no-isolate exclude each other: keep one")
        which: Literal["foreign", "all", "none"] = "foreign"
        if self.isolate or self.no_isolate:
            which = "all" if self.isolate else "none"
        return Isolation(which, self.time_limit, self.memory_limit)

    def specs(
        self, trackers: "Iterable[str | mot_sim.experiments.sweep.TrackerSpec]"
    ) -> "tuple[mot_sim.experiments.sweep.TrackerSpec, ...]":
        """The trackers of these names, to be run as the options say."""
        from mot_sim.experiments.sweep.tracker_specs import tracker_specs_of

        isolation = self.read()
        found = tracker_specs_of(tuple(trackers))
        return tuple(replace(each, isolation=isolation) for each in found)


@dataclass(frozen=True)
class KittiOptions:
    """Which drives of a KITTI tree, and what is known about them."""

    root: Root = None
    """The folder that holds training/ and, beside it, detections/ and odometry/."""
    sequences: Annotated[str | None, option("NAMES", "all")] = None
    """all, labelled (those with labels; given is the same), or names: 0000,0005."""
    seqmap: Annotated[Path | None, option("FILE", "all frames")] = None
    """Sequences and frames, a line `NAME empty FIRST END` each (from 0; END is after the last)."""
    frames: Annotated[str | None, option("PART", "all")] = None
    """first-half or second-half of every sequence, or FIRST-LAST. Tracking begins there anew."""
    split: Annotated[str | None, option("NAME", SPLIT)] = None
    """training or testing."""
    detections: Annotated[str | None, option("NAME|PATH", DETECTIONS)] = None
    """A detector of <root>/detections (mot-sim list), or a folder of SSSS.txt or one file."""
    classes: Annotated[str | None, option("NAMES", "those of the detections")] = None
    """What is tracked, each class by itself: car, pedestrian, cyclist, or several: car,pedestrian.
    Several detectors are named with commas: --detections rrc,rrc_pedestrian."""
    detection_format: Annotated[str | None, option("NAME", "the detector's own")] = None
    """How the rows of a folder or file of your own are written: the name of a detector."""
    ego: Annotated[str | None, option("NAME|FILE", "oxts; none with --boxes")] = None
    """Where the camera's motion comes from: oxts, orbslam3, visual (seen in the images), none.
    With --boxes: none, visual (needs --images), or a file with a 3x4 camera-to-world matrix
    (12 numbers, metres) a line, one line a frame; or with times, as TUM's trajectories (time tx ty
    tz qx qy qz qw) or time and the matrix: between them is interpolated. A folder of drives may
    have a folder with NAME.txt."""
    ego_scale: Annotated[str | None, option("NAME", "metres")] = None
    """auto: the poses have a scale of their own, as those of one camera have (ORB-SLAM and its
    like); metres are found while the drive is played, by the cars that the camera passes and the
    camera's height. Until then the translation counts as unknown."""
    height: Annotated[float | None, option("METRES", f"{CAMERA_HEIGHT}")] = None
    """Of the camera above the road."""
    pitch: Annotated[float | None, option("DEGREES", "0")] = None
    """Of the camera; positive looks up."""
    every: Annotated[int | None, option("N", "as the boxes say")] = None
    """The detector looked at every Nth frame only: the others get predicted rows, and no track is
    the worse for them. Where all boxes lie in every Nth frame this is found out; 1: it looked at
    all frames."""
    cuboids: Flag = False
    """Read the detector's cuboids, too (pointrcnn has some), for --tracker cuboids."""
    drop_bad_boxes: Flag = False
    """Leave out boxes without area and boxes outside the image, instead of refusing the file."""

    score_map: Annotated[str | None, option("MIDPOINT,SCALE", "the detector's own")] = None
    """From the file's scores to probabilities, which the trackers' thresholds take them for: half
    of the boxes with a score of MIDPOINT are right, 73 % of those SCALE above it."""

    def parsed_score_map(self) -> "mot_sim.datasets.ScoreMap | None":
        """The score map that was asked for."""
        from mot_sim.datasets import ScoreMap

        return None if self.score_map is None else ScoreMap.parse(self.score_map)

    @property
    def metric(self) -> bool:
        """Whether poses are in metres."""
        from tracker.errors import UnknownName

        if self.ego_scale not in (None, "auto"):
            raise UnknownName.of("scale of the ego-motion", str(self.ego_scale), ("auto",))
        return self.ego_scale is None

    def kinds(self) -> tuple[str, ...] | None:
        """The classes that were asked for; None: those of the detections."""
        from tracker.types import parse_kinds

        return None if self.classes is None else parse_kinds(self.classes)

    def looks(self) -> "mot_sim.files.settings.Settings":
        """Which frames were looked at, where that was said."""
        return {} if self.every is None else {"every": self.every}

    def named(self) -> list[str]:
        """The options of a KITTI tree that were given."""
        mine = (
            "root",
            "sequences",
            "seqmap",
            "frames",
            "split",
            "detections",
            "detection_format",
            "height",
            "pitch",
        )
        return [name for name in mine if getattr(self, name) is not None]

    def open(
        self, sequences: str = "all", images: bool = False
    ) -> "list[mot_sim.datasets.KittiSequence]":
        """The drives, every file of theirs read and checked. images: they must have some."""
        from mot_sim.datasets import kitti_sequence
        from mot_sim.evaluation.scoring import ALL_SEQUENCES, choose_sequences
        from mot_sim.evaluation.splits import Split

        split = self.split or SPLIT
        parts = Split.of(self.seqmap, self.frames)
        chosen = choose_sequences(self.root, self.sequences or sequences, split)
        if parts.ranges is not None:
            chosen = parts.sequences(choose_sequences(self.root, ALL_SEQUENCES, split))
        drives = [
            kitti_sequence(
                self.root,
                name,
                self.detections or DETECTIONS,
                self.ego or EGO,
                images,
                split=split,
                height=CAMERA_HEIGHT if self.height is None else self.height,
                pitch=radians(self.pitch or 0.0),
                detection_format=self.detection_format,
                bad_boxes="drop" if self.drop_bad_boxes else None,
                cuboids=self.cuboids,
                score_map=self.parsed_score_map(),
                every=self.every,
                kinds=self.kinds(),
                metric=self.metric,
            )
            for name in chosen
        ]
        return [parts.part(drive) for drive in drives]

    def settings(self) -> "mot_sim.files.settings.Settings":
        """What decides the results, with the defaults filled in."""
        from mot_sim.datasets import find_root

        return {
            "root": str(find_root(self.root).resolve()),
            "split": self.split or SPLIT,
            "detections": self.detections or DETECTIONS,
            "detection_format": self.detection_format,
            "ego": self.ego or EGO,
            "height": CAMERA_HEIGHT if self.height is None else self.height,
            "pitch_deg": self.pitch or 0.0,
            "drop_bad_boxes": self.drop_bad_boxes,
            **self.looks(),
            **({"cuboids": True} if self.cuboids else {}),
            **({} if self.ego_scale is None else {"ego_scale": self.ego_scale}),
            **({} if self.classes is None else {"classes": self.classes}),
            **({} if self.frames is None else {"frames": self.frames}),
            **({} if self.seqmap is None else {"seqmap": str(self.seqmap.resolve())}),
            "score_map": self.score_map,
        }


@dataclass(frozen=True)
class TrackerOptions:
    """What is changed in a tracker."""

    costs: Annotated[str | None, option("NAME=WEIGHT,...", "the tracker's own")] = None
    """Pairwise costs and their weights, for example volume=0.6,reprojection=0.4; of your own too:
    my_module:MyCost=0.5."""
    association: Annotated[str | None, option("NAME", "the tracker's own")] = None
    """hungarian or greedy: two frames, online; window: decided a second later, over the frames
    until then; network_flow: over the whole drive. The last two fill gaps and drop weak tracks."""
    lag: Annotated[int | None, option("N", "none: rows at once")] = None
    """Decide the rows of a frame N frames later, over the frames until then (a sliding window, 10
    are a second): surer ids, gaps filled, places and headings smoothed."""
    cues: Annotated[str | None, option("NAMES", "none")] = None
    """What is measured in the images and joins the costs: all (pose,appearance), none, classical,
    or a list of: pose (keypoints, shape and pose, by the shipped network), appearance (its
    descriptor), classical (a descriptor of colours and gradients, no network). Needs images."""

    def recipe(
        self, tracker: str, kinds: tuple[str, ...] = ("Car",)
    ) -> "mot_sim.evaluation.runs.Recipe":
        """How to build a tracker of this name for these classes; all names are checked."""
        from mot_sim.evaluation.runs import Recipe, parse_costs

        costs = None if self.costs is None else parse_costs(self.costs)
        return Recipe(tracker, costs, self.association, self.cues or "none", kinds, self.lag)

    @property
    def wants_images(self) -> bool:
        """Whether any cue is to be measured."""
        return self.cues not in (None, "none")

    def settings(self, tracker: str) -> "mot_sim.files.settings.Settings":
        """What decides the results; source: of what is none of ours."""
        from mot_sim.evaluation.runs import parse_costs
        from mot_sim.files.named_objects import ASSOCIATION_NAMES, COST_NAMES, TRACKER_NAMES

        costs = None if self.costs is None else parse_costs(self.costs)
        sources = [
            TRACKER_NAMES.source(tracker),
            *(COST_NAMES.source(name) for name in costs or {}),
            None if self.association is None else ASSOCIATION_NAMES.source(self.association),
        ]
        own = [source for source in sources if source is not None]
        weights = [f"{name}={weight!r}" for name, weight in sorted((costs or {}).items())]
        return {
            "tracker": tracker,
            "costs": ",".join(weights) or None,
            "association": self.association,
            "cues": self.cues if self.wants_images else None,
            **({} if self.lag is None else {"lag": str(self.lag)}),
            **({"source": ",".join(own)} if own else {}),
        }


@dataclass(frozen=True)
class FolderOptions:
    """What happens to results that are there already."""

    resume: Flag = False
    """Go on with an interrupted run: what is finished stays, the rest is done."""
    overwrite: Flag = False
    """Replace what an earlier run left in the output folder."""

    def open(
        self, path: Path, settings: "mot_sim.files.settings.Settings", names: list[str]
    ) -> "mot_sim.evaluation.run_folder.RunFolder":
        """The folder, checked; nothing is written yet."""
        from mot_sim.evaluation.run_folder import RunFolder

        return RunFolder.open(path, settings, names, resume=self.resume, overwrite=self.overwrite)


def parse_knobs(scene: str, text: str | None) -> "dict[str, mot_sim.simulation.scene.Knob]":
    """The knobs that `NAME=VALUE,...` turns, each of the type that the scene's own value has."""
    from mot_sim.simulation.registry import knobs_of
    from tracker.errors import BadConfig

    known, turned = knobs_of(scene), {}
    for part in (text or "").split(",") if text else ():
        name, equals, value = (word.strip() for word in part.partition("="))
        if not (name and equals and value):
            raise BadConfig(f"--knobs {text}: write NAME=VALUE,NAME=VALUE")
        if name in turned:
            raise BadConfig(f"--knobs {text}: {name} stands there twice; set it once")
        turned[name] = _of_kind(type(known.get(name, "")), name, value)
    return turned


def _of_kind(kind: type, name: str, value: str) -> "mot_sim.simulation.scene.Knob":
    """The value that a text spells."""
    from tracker.errors import BadConfig

    spelled = {"true": True, "false": False}
    words = {bool: "true or false", int: "a whole number", float: "a number"}
    try:
        return spelled[value.lower()] if kind is bool else kind(value)
    except (ValueError, KeyError):
        raise BadConfig(f"--knobs {name}={value}: give {words[kind]}") from None

"""`mot-sim compare`: our trackers and external ones side by side."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from mot_sim.cli.evaluate import deliver, require_targets, say_unlabelled
from mot_sim.cli.keeping import keep
from mot_sim.cli.options import (
    DETECTIONS,
    EGO,
    File,
    IsolationOptions,
    KittiOptions,
    Rules,
    Verbose,
    option,
    parse_knobs,
)
from mot_sim.cli.terminal import BROKEN, OK, WRONG, Terminal

if TYPE_CHECKING:
    import mot_sim.datasets
    import mot_sim.experiments.guests
    import tracker

DEFAULT_TRACKERS = "default,paper,iou"
DEFAULT_TIMEOUT_SECONDS = 600.0
DEFAULT_SEEDS = "0-4"


@dataclass(frozen=True)
class SceneOptions:
    """A scene instead of a KITTI tree."""

    scene: Annotated[str | None, option("NAME")] = None
    """Compare on runs of this scene (mot-sim list), recorded now, without images."""
    seeds: Annotated[str | None, option("DEFAULT_SEEDS", DEFAULT_SEEDS)] = None
    """Seeds of the runs: 0-4, or 3,7,11."""
    knobs: Annotated[str | None, option("NAME=VALUE,...", "the scene's own")] = None
    """What is changed in the scene."""

    def named(self) -> list[str]:
        """The options of a scene that were given."""
        return [name for name in ("scene", "seeds", "knobs") if getattr(self, name) is not None]


@dataclass(frozen=True)
class Compare:
    """Score our trackers and external ones side by side.

    mot-sim compare --setup sort

    mot-sim compare --root KITTI --detections rrc --trackers default,iou,sort,oc-sort

    mot-sim compare --scene intersection --seeds 0-9 --trackers default,mine \\
    --guest "mine=python mine.py {detections} {results}"

    One row per tracker over all drives: quality, and frames per CPU second of the tracker's calls
    alone, measured one after the other on one core, after a few untimed frames. External trackers
    (guests) exchange files and run in environments of their own (docs/guests.md). If one fails,
    its stderr is shown, the others continue, and the exit code is 1.
    """

    trackers: Annotated[str, option("NAMES", DEFAULT_TRACKERS)] = DEFAULT_TRACKERS
    """Ours and yours as for mot-sim sweep: default, paper, mine=MODULE:CALLABLE. Baselines over two
    frames: iou, iou-greedy. Guests: sort, sort-3, bytetrack, oc-sort, oc-sort-3, c-biou, bot-sort,
    norfair, motpy, and those of --guest."""
    setup: Annotated[str | None, option("NAMES")] = None
    """Only create the environments of these guests (or: all), once; this needs a package index.
    They are put into $MOT_SIM_GUESTS, else into your cache folder."""
    guest: Annotated[tuple[str, ...], option("NAME=COMMAND...")] = ()
    """Guests of your own; the command's {detections} and {results} become folders."""
    guest_score: Annotated[str | None, option("NUMBER|NAME=NUMBER,...", "each guest's own")] = None
    """Guests get only boxes with at least this score (a probability)."""
    timeout: Annotated[float, option("DEFAULT_TIMEOUT_SECONDS", f"{DEFAULT_TIMEOUT_SECONDS:g}")] = (
        DEFAULT_TIMEOUT_SECONDS
    )
    """How long a guest may take, all drives together."""
    isolation: IsolationOptions = field(default_factory=IsolationOptions)
    """Where Python trackers run, and what they may take there, drive by drive."""
    kitti: KittiOptions = field(default_factory=KittiOptions)
    """The drives of a KITTI tree, unless --scene is given, and what is known about them."""
    scenes: SceneOptions = field(default_factory=SceneOptions)
    """A scene instead of a KITTI tree."""
    rules: Rules = "trackeval"
    """trackeval (1.3.0), or devkit2018: KITTI's kit of the paper's time, CLEAR only."""
    out: Annotated[Path | None, option("DIR", "results are not kept")] = None
    """A new or empty folder for DIR/TRACKER/SSSS.txt and DIR/TRACKER/exchange, a guest's files."""
    json: File = None
    """All scores as JSON into a file; - prints them instead of the table."""
    csv: File = None
    """The table as CSV into a file; - prints it instead of the table."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Compare and show."""
        from mot_sim.evaluation.scoring import require_rules
        from mot_sim.experiments.guests import run_comparison
        from mot_sim.files.settings import require_empty

        if self.setup is not None:
            return self._set_up(terminal)
        require_rules(self.rules)
        require_targets(self.json, self.csv)
        if self.out is not None:
            require_empty(self.out)
        trackers = self._named_trackers()
        drives, truths, what = self._drives()
        unlabelled = tuple(drive.name for drive in drives if drive.name not in truths)
        drives = [drive for drive in drives if drive.name in truths]
        comparison = run_comparison(trackers, drives, truths, self.rules, self._keep(drives))
        title = f"{what}, rules {self.rules}, rates and scores in %"
        deliver(terminal, comparison.table(title), comparison.as_dict(), self.json, self.csv)
        keep(self.out, "compare", f"{what}, rules {self.rules}", comparison.tables())
        say_unlabelled(terminal, unlabelled)
        say_failures(terminal, comparison.failures)
        return BROKEN if comparison.failures else OK

    def _set_up(self, terminal: Terminal) -> int:
        """Make the environments that were asked for."""
        from mot_sim.experiments.guests import GUESTS, Environment, ExternalTrackerFailed
        from tracker.errors import UnknownName

        names = list(GUESTS) if self.setup == "all" else names_in(str(self.setup))
        for name in names:
            if name not in GUESTS:
                raise UnknownName.of("guest", name, ["all", *GUESTS])
        by_environment: dict[Environment, list[str]] = {}
        for name in names:
            environment = GUESTS[name].environment
            if environment is not None:
                by_environment.setdefault(environment, []).append(name)
        failed = False
        for environment, guests in by_environment.items():
            try:
                environment.set_up(", ".join(guests))
            except ExternalTrackerFailed as failure:
                failed = True
                terminal.error(str(failure))
                say_stderr(terminal, guests[0], failure.stderr)
            else:
                terminal.write(f"{', '.join(guests)}: ready in {environment.path}\n")
        return WRONG if failed else OK

    def _named_trackers(self) -> "list[mot_sim.experiments.guests.SequenceTracker]":
        """The trackers that were named, the guests among them as the options say."""
        from mot_sim.experiments.guests import (
            BASELINES,
            GUESTS,
            ExternalTracker,
            find_sequence_tracker,
            parse_scores,
            with_scores,
        )
        from tracker import TRACKERS
        from tracker.errors import BadConfig

        guests = dict(GUESTS)
        for text in self.guest:
            mine = ExternalTracker.parse(text)
            if mine.name in {*guests, *TRACKERS, *BASELINES}:
                raise BadConfig(f"--guest {mine.name}: there is a {mine.name} already; rename it")
            guests[mine.name] = mine
        guests = {name: replace(each, timeout=self.timeout) for name, each in guests.items()}
        if self.guest_score is not None:
            guests = with_scores(guests, parse_scores(self.guest_score))
        isolation = self.isolation.read()
        return [
            find_sequence_tracker(
                name, guests, self.out and self.out / name / "exchange", isolation
            )
            for name in names_in(self.trackers)
        ]

    def _drives(
        self,
    ) -> "tuple[list[mot_sim.datasets.RecordedSequence], dict[str, tracker.Tracks], str]":
        """The drives, their labels, and what they are."""
        from tracker.errors import BadConfig, DatasetNotFound

        if self.scenes.scene is not None:
            if self.kitti.named():
                raise BadConfig(f"--scene and --{self.kitti.named()[0]} exclude each other")
            return self._runs(self.scenes.scene)
        if self.scenes.named():
            raise BadConfig(f"--{self.scenes.named()[0]} belongs to --scene: give that too")
        drives = self.kitti.open("labelled")
        truths = {drive.name: drive.truth for drive in drives if drive.truth is not None}
        if not truths:
            raise DatasetNotFound("no labels for any of these sequences: nothing can be scored")
        what = f"{self.kitti.detections or DETECTIONS} boxes, ego {self.kitti.ego or EGO}"
        return list(drives), truths, what

    def _runs(
        self, scene: str
    ) -> "tuple[list[mot_sim.datasets.RecordedSequence], dict[str, tracker.Tracks], str]":
        """Runs of a scene, named after their seeds."""
        from mot_sim.simulation.episode import record
        from mot_sim.simulation.registry import find_scene

        made = find_scene(scene, **parse_knobs(scene, self.scenes.knobs))
        spelled = self.scenes.seeds or DEFAULT_SEEDS
        episodes = [
            replace(record(made, seed), name=f"{scene}-{seed}") for seed in parse_seeds(spelled)
        ]
        truths = {episode.name: episode.truth for episode in episodes}
        return list(episodes), truths, f"{scene}, seeds {spelled}"

    def _keep(
        self, drives: "list[mot_sim.datasets.RecordedSequence]"
    ) -> "mot_sim.experiments.guests.comparison.Keep | None":
        """What writes the tracks into the output folder, where one is given."""
        from mot_sim.datasets import write_results

        if self.out is None:
            return None
        folder = self.out

        def keep(tracker: str, tracks: "Mapping[str, tracker.Tracks]") -> None:
            for name, rows in tracks.items():
                write_results(rows, folder / tracker / f"{name}.txt")

        return keep


def say_failures(
    terminal: Terminal, failures: "Mapping[str, mot_sim.experiments.guests.Failure]"
) -> None:
    """Name the trackers that failed, with what they said on stderr."""
    for name, failure in failures.items():
        terminal.error(failure.reason)
        say_stderr(terminal, name, failure.stderr)


def say_stderr(terminal: Terminal, name: str, stderr: str) -> None:
    """What a guest said, each line marked with its name."""
    for line in stderr.splitlines():
        terminal.note(f"  {name}: {line}")


def parse_seeds(text: str) -> list[int]:
    """The numbers that `0-4` or `3,7,11` spells."""
    from tracker.errors import BadConfig

    seeds: list[int] = []
    for part in text.split(","):
        first, dash, last = (word.strip() for word in part.partition("-"))
        if not first.isdecimal() or (dash and not last.isdecimal()):
            raise BadConfig(f"--seeds {text}: write 0-4, or 3,7,11")
        seeds += range(int(first), int(last or first) + 1)
    if not seeds:
        raise BadConfig(f"--seeds {text}: no seed; write 0-4, the smaller one first")
    return list(dict.fromkeys(seeds))


def names_in(text: str | None) -> list[str]:
    """The names in a list, each once, in the given order; none for no list."""
    if text is None:
        return []
    return list(dict.fromkeys(name.strip() for name in text.split(",")))

"""`assert_tracks`: a tracker must reach scores on an episode, or the first bad frame is shown."""

from dataclasses import replace
from typing import Any

from mot_sim.experiments.sweep.bounds import Bound, bounds_of
from mot_sim.experiments.sweep.following import follow, name_of
from mot_sim.experiments.sweep.seeded_episodes import SeededEpisode
from mot_sim.metrics import Scores, evaluate_sequence
from mot_sim.tables import title_of
from mot_sim.testing.mistakes import MISTAKE_KINDS, Kind, Mistakes

MAX_SHOWN_MISTAKES = 5  # mistakes of the first bad frame
# The mistakes that a score is about; the others are about all three kinds.
KINDS_BY_METRIC: dict[str, tuple[Kind, ...]] = {
    "IDSW": ("switch",), "AssA": ("switch",), "CLR_FN": ("miss",), "CLR_Re": ("miss",),
    "CLR_TP": ("miss",), "CLR_FP": ("false positive",), "CLR_Pr": ("false positive",),
    "FP_per_frame": ("false positive",),
}  # fmt: skip


def assert_tracks(tracker: Any, episode: SeededEpisode, **bounds: float | int) -> Scores:
    """Follow the episode with the tracker, and assert that its scores keep the bounds.

    tracker: see `follow`. bounds: by name, in small letters or as TrackEval writes them: mota,
    hota, idf1, assa, deta, recall, precision (at least; fractions), idsw, frag, fp, fn, ml (at
    most), mt, tp (at least); those of cuboids as `**{"mota3d@2m": 0.6, "centre_median": 1.0}`.
    Gives the scores. The AssertionError shows every bound that is
    broken and the first bad frame: which car, which ids, which boxes, what happened. Raises
    TrackerFailed for a tracker that fails, UnknownName and BadConfig for bounds that cannot be.
    """
    __tracebackhide__ = True
    wanted = bounds_of(bounds)
    output = follow(tracker, episode)
    scores = evaluate_sequence(episode.truth, output, episode.frame_count)
    if any(bound.is_spatial for bound in wanted):
        scores = replace(scores, spatial=episode.drive.spatial_scores(output))
    broken = [bound for bound in wanted if not bound.holds(float(scores[bound.metric]))]
    if broken:
        mistakes = Mistakes.of(episode.truth, output, episode.frame_count)
        raise AssertionError(_message(name_of(tracker), episode, broken, scores, mistakes))
    return scores


def _message(
    tracker: str,
    episode: SeededEpisode,
    broken: list[Bound],
    scores: Scores,
    mistakes: Mistakes,
) -> str:
    """What was asked, what came, and where it went wrong first."""
    lines = [f"{tracker} on {episode.name}:"]
    for bound in broken:
        score = float(scores[bound.metric])
        lines.append(
            f"  {title_of(bound.metric)} {_number(score)}, "
            f"must be {bound.word} {_number(bound.value)}"
        )
    kinds = tuple(
        dict.fromkeys(
            kind for each in broken for kind in KINDS_BY_METRIC.get(each.metric, MISTAKE_KINDS)
        )
    )
    return "\n".join([*lines, *_mistaken(mistakes, kinds, len(episode))])


def _mistaken(mistakes: Mistakes, kinds: tuple[Kind, ...], frames: int) -> list[str]:
    """The first bad frame, the first mistakes of the other kinds in question, and how many."""
    first = mistakes.first(kinds) or mistakes.first()
    if first is None:
        return ["no car was missed, switched or invented: only boxes lie badly"]
    here = sorted(mistakes.in_frame(first.frame), key=lambda each: each.kind not in kinds)
    lines = [
        f"first bad frame: {first.frame}",
        *(f"  {each}" for each in here[:MAX_SHOWN_MISTAKES]),
    ]
    if len(here) > MAX_SHOWN_MISTAKES:
        lines.append(f"  and {len(here) - MAX_SHOWN_MISTAKES} more in this frame")
    for kind in kinds:
        later = mistakes.first((kind,))
        if later is not None and later.frame != first.frame:
            lines += [f"first {kind}: frame {later.frame}", f"  {later}"]
    counts = mistakes.counts()
    told = ", ".join(f"{counts[kind]} {_plural(kind, counts[kind])}" for kind in MISTAKE_KINDS)
    return [*lines, f"in all {frames} frames: {told}"]


def _plural(kind: str, count: int) -> str:
    return kind if count == 1 else {"switch": "switches", "miss": "misses"}.get(kind, f"{kind}s")


def _number(value: float) -> str:
    """A count without a fraction, a rate with four digits."""
    return f"{value:.0f}" if value.is_integer() and abs(value) > 1.0 else f"{value:.4g}"


__all__ = ["assert_tracks"]

"""Verdicts in the forms that CI reads: JUnit's XML, and Markdown for the summary of a job."""

import re
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from platform import node
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from mot_sim.experiments.stress.baseline import BaselineVerdict
from mot_sim.experiments.stress.suites import Verdict, score_word, verdict_table

NO_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def junit_xml(
    verdicts: Sequence[Verdict],
    drifts: Sequence[BaselineVerdict] = (),
    seconds: Mapping[str, float] | None = None,
) -> str:
    """JUnit's XML: a test suite a stress suite, a test case a bound and a score of a baseline.

    A bound that is broken is a failure, a tracker with a failed trial an error, once for each of
    its bounds. seconds: that each suite took, by its name.
    """
    root = Element("testsuites", name="mot-sim stress")
    for place, suite in enumerate(dict.fromkeys(each.suite for each in verdicts)):
        part = SubElement(
            root, "testsuite", name=suite, id=str(place), package="mot-sim",
            hostname=_plain(node()) or "localhost", time=f"{(seconds or {}).get(suite, 0.0):.3f}",
            timestamp=datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%S"),
        )  # fmt: skip
        SubElement(part, "properties")
        for verdict in verdicts:
            if verdict.suite == suite:
                _bound_case(part, verdict)
        for drift in drifts:
            if drift.suite == suite:
                _baseline_case(part, drift)
        SubElement(part, "system-out")
        SubElement(part, "system-err")
        _count(part)
    _count(root)
    indent(root)
    text: str = tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'


def _bound_case(part: Element, verdict: Verdict) -> None:
    bound = verdict.bound
    limit = f"{bound.word} {score_word(bound.metric, bound.value)}"
    case = _case(part, verdict.suite, verdict.tracker, f"{bound.metric} {limit}")
    if verdict.failed:
        said = f"{verdict.failed} trials failed: {verdict.error}"
        SubElement(case, "error", message=_plain(said), type="TrackerFailed").text = _plain(said)
    elif not verdict.passed:
        said = f"{bound.metric} {_reached(verdict)}, must be {limit}"
        SubElement(case, "failure", message=_plain(said), type="Bound").text = _plain(said)


def _baseline_case(part: Element, drift: BaselineVerdict) -> None:
    case = _case(part, drift.suite, drift.tracker, f"{drift.metric} as the baseline")
    if not drift.passed:
        said = _plain(f"{drift.metric} {drift.told}")
        SubElement(case, "failure", message=said, type="Baseline").text = said


def _case(part: Element, suite: str, tracker: str, name: str) -> Element:
    return SubElement(
        part, "testcase", classname=_plain(f"{suite}.{tracker}"), name=_plain(name), time="0"
    )


def _count(part: Element) -> None:
    """Write how many test cases are inside, and what became of them."""
    inside = {"tests": "testcase", "failures": "failure", "errors": "error", "skipped": "skipped"}
    for name, tag in inside.items():
        if part.tag == "testsuite" or name != "skipped":
            part.set(name, str(sum(1 for _ in part.iter(tag))))


def _plain(text: str) -> str:
    """Without the characters that XML cannot hold."""
    return NO_XML.sub("?", text)


def _reached(verdict: Verdict) -> str:
    reached, metric = verdict.reached, verdict.bound.metric
    if reached.mean is None:
        return "none"
    ends = [score_word(metric, end) for end in (reached.low, reached.high) if end is not None]
    return score_word(metric, reached.mean) + (f" [{', '.join(ends)}]" if ends else "")


def markdown_summary(verdicts: Sequence[Verdict], drifts: Sequence[BaselineVerdict] = ()) -> str:
    """The verdicts for the summary of a job: how many bounds are kept, a table, what failed."""
    kept = sum(each.passed for each in verdicts)
    lines = [f"## mot-sim stress: {kept} of {len(verdicts)} bounds are kept", ""]
    lines += [verdict_table(verdicts).as_markdown().rstrip(), ""]
    if drifts:
        same = sum(each.passed for each in drifts)
        lines += [f"{same} of {len(drifts)} scores are as good as the baseline's.", ""]
    lines += [
        f"- worse than the baseline: {each.suite}, {each.tracker}: {each.metric} {each.told}"
        for each in drifts
        if not each.passed
    ]
    return "\n".join(lines).rstrip() + "\n"


__all__ = ["junit_xml", "markdown_summary"]

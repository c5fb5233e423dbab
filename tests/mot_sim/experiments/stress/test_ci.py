"""What CI is told: JUnit's XML, a job's summary, baselines; and what is refused before a run."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from mot_sim.__main__ import main
from mot_sim.experiments.stress.baseline import (
    BaselineVerdict,
    read_baseline,
    require_baseline,
    write_baseline,
)
from mot_sim.experiments.stress.ci_reports import junit_xml, markdown_summary
from mot_sim.experiments.stress.suites import Suite, Verdict
from mot_sim.experiments.sweep.bounds import Bound
from mot_sim.tables import Interval
from tests.mot_sim.experiments.stress.test_suites import suites
from tracker.errors import BadConfig, BadFile

__all__ = ["suites"]

EASY = Suite("easy", "an open road", "crossing", 5, (Bound("HOTA", 0.7), Bound("IDSW", 2.0)))
SCORES = Interval(0.70, 0.65, 0.75, 8), Interval(1.0, 0.5, 1.5, 8)
VERDICTS = [
    Verdict("easy", "mine", bound, score) for bound, score in zip(EASY.bounds, SCORES, strict=True)
]
BROKEN = replace(VERDICTS[0], reached=Interval(0.5, 0.4, 0.6, 8))
FAILED = replace(VERDICTS[1], failed=2, error="frame 2: <no> \x00 & car")
# The schema of JUnit's XML that CI servers share: attributes that must be there, and children in
# their order.
MUST = {
    "testsuites": ({"name", "tests", "failures", "errors"}, ["testsuite"]),
    "testsuite": (
        {"name", "id", "package", "timestamp", "hostname", "tests", "failures", "errors", "time"},
        ["properties", "testcase", "system-out", "system-err"],
    ),
    "testcase": ({"name", "classname", "time"}, ["error", "failure"]),
    "failure": ({"message", "type"}, []),
    "error": ({"message", "type"}, []),
}


def require_schema(element: ElementTree.Element) -> None:
    """Assert that an element, and all inside, are as the schema has them."""
    attributes, order = MUST.get(element.tag, (set(), []))
    assert attributes <= set(element.keys()), element.tag
    places = [order.index(child.tag) for child in element]
    assert places == sorted(places)
    for child in element:
        require_schema(child)


def drift(now: float, metric: str = "HOTA") -> BaselineVerdict:
    before = SCORES[0] if metric == "HOTA" else SCORES[1]
    reached = Interval(now, now, now, 8)
    return BaselineVerdict("easy", "mine", metric, metric == "IDSW", reached, before)


def test_a_bound_is_a_test_case_that_the_schema_allows() -> None:
    text = junit_xml([VERDICTS[0], BROKEN, FAILED], [drift(0.7), drift(0.6)], {"easy": 1.5})
    root = ElementTree.fromstring(text.encode())
    require_schema(root)
    (suite,) = root
    assert (suite.get("tests"), suite.get("failures"), suite.get("errors")) == ("5", "2", "1")
    assert (suite.get("name"), suite.get("time")) == ("easy", "1.500")
    cases = suite.findall("testcase")
    assert [case.get("name") for case in cases] == [
        "HOTA at least 0.700", "HOTA at least 0.700", "IDSW at most 2.0",
        "HOTA as the baseline", "HOTA as the baseline",
    ]  # fmt: skip
    assert {case.get("classname") for case in cases} == {"easy.mine"}
    assert [[child.tag for child in case] for case in cases] == [
        [], ["failure"], ["error"], [], ["failure"]
    ]  # fmt: skip
    assert cases[1][0].get("message") == "HOTA 0.500 [0.400, 0.600], must be at least 0.700"
    assert cases[2][0].get("message") == "2 trials failed: frame 2: <no> ? & car"


def test_the_summary_of_a_job_is_a_table() -> None:
    text = markdown_summary([VERDICTS[0], BROKEN], [drift(0.7), drift(0.6)])
    assert text.startswith("## mot-sim stress: 1 of 2 bounds are kept\n\n| suite | tracker |")
    assert "1 of 2 scores are as good as the baseline's." in text
    assert "- worse than the baseline: easy, mine: HOTA 0.600, baseline 0.700 ± 0.050" in text


def test_worse_is_what_lies_outside_the_interval_of_the_baseline() -> None:
    assert [drift(now).passed for now in (0.9, 0.7, 0.651, 0.649)] == [True, True, True, False]
    assert [drift(now, "IDSW").passed for now in (0.0, 1.5, 1.6)] == [True, True, False]
    assert drift(0.6).worse_by == pytest.approx(0.1)
    assert drift(0.6).told == "0.600, baseline 0.700 ± 0.050: 0.100 worse"
    assert drift(0.5, "IDSW").told == "0.5, baseline 1.0 ± 0.5: 0.5 better"
    none = replace(drift(0.7), reached=Interval(None, None, None, 0))
    assert (none.passed, none.told) == (False, "no score")


def written(path: Path, **changes: Any) -> dict[str, Any]:
    """The baseline of VERDICTS, with some of its content changed."""
    write_baseline(path, [EASY], VERDICTS, 0)
    content = {**json.loads(path.read_text()), **changes}
    path.write_text(json.dumps(content))
    return content


def test_a_baseline_is_read_back(tmp_path: Path) -> None:
    path = tmp_path / "base.json"
    assert written(path) == read_baseline(path)
    scores = read_baseline(path)["suites"]["easy"]["trackers"]["mine"]
    assert scores["HOTA"] == {"mean": 0.7, "low": 0.65, "high": 0.75, "count": 8}
    require_baseline(read_baseline(path), path, [EASY], ["mine"], range(8))
    kept = replace(EASY, bounds=(Bound("HOTA", 0.1),))  # other bounds are no other suite
    require_baseline(read_baseline(path), path, [kept], ["mine"], range(8))


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"mot-sim baseline": 7}, "a baseline of format 7, not 1"),
        ({"mot-sim": "0.0.1"}, "a baseline of mot-sim '0.0.1', this is"),
        ({"suites": 3}, "no baseline of mot-sim stress"),
        ({"suites": {"fog": {}}}, "it has no suite easy, only fog"),
        ({"suites": {"easy": {"suite": "x", "trackers": {}}}}, "suite easy was another"),
        ({"first_seed": 5}, "its runs are 8 from seed 5, these are 8 from seed 0"),
    ],
)
def test_a_baseline_of_something_else_is_refused(
    tmp_path: Path, changes: dict[str, Any], told: str
) -> None:
    path = tmp_path / "base.json"
    written(path, **changes)
    with pytest.raises(BadFile, match=f"base.json: {told}.*--update-baseline"):
        require_baseline(read_baseline(path), path, [EASY], ["mine"], range(8))


def test_a_baseline_of_other_runs_is_refused_and_failures_are_none(tmp_path: Path) -> None:
    path = tmp_path / "base.json"
    content = written(path)
    with pytest.raises(BadFile, match="has no tracker other, only mine"):
        require_baseline(content, path, [EASY], ["other"], range(8))
    with pytest.raises(BadFile, match="its runs are 8 from seed 0, these are 3"):
        require_baseline(content, path, [EASY], ["mine"], range(3))
    more = replace(EASY, bounds=(Bound("MOTA", 0.1),))
    with pytest.raises(BadFile, match="easy, mine: no mean with its interval"):
        require_baseline(content, path, [more], ["mine"], range(8))
    path.write_text("{")
    with pytest.raises(BadFile, match="no baseline can be read"):
        read_baseline(path)
    with pytest.raises(BadConfig, match="2 trials failed: no baseline is written"):
        write_baseline(path, [EASY], [FAILED], 0)
    single = replace(VERDICTS[0], reached=Interval(0.7, None, None, 1))
    with pytest.raises(BadConfig, match="--seeds 2 or more"):
        write_baseline(path, [EASY], [single], 0)


def test_the_command_writes_a_baseline_and_then_fails_for_less(
    suites: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    base, junit, summary = (tmp_path / name for name in ("base.json", "out.xml", "summary.md"))
    line = [
        "stress", "easy", "--file", str(suites), "--seeds", "2", "--out", str(tmp_path / "out"),
        "--baseline", str(base), "--junit", str(junit), "--markdown", str(summary),
    ]  # fmt: skip
    assert main(line) == 0
    assert "the baseline of later runs" in capsys.readouterr().err.replace("\n", " ")
    assert main(line) == 0
    assert "2 of 2 scores are as good as those of" in capsys.readouterr().err.replace("\n", " ")
    content = json.loads(base.read_text())
    score = content["suites"]["easy"]["trackers"]["default"]["HOTA"]
    score.update({name: min(score[name] + 0.5, 1.5) for name in ("mean", "low", "high")})
    base.write_text(json.dumps(content))
    assert main(line) == 1
    told = " ".join(capsys.readouterr().err.split())
    assert "worse than the baseline: easy, default: HOTA 0." in told
    assert "0.500 worse" in told
    root = ElementTree.parse(junit).getroot()
    require_schema(root)
    assert (root.get("tests"), root.get("failures")) == ("4", "1")
    assert "2 of 2 bounds are kept" in summary.read_text()
    assert main([*line, "--update-baseline"]) == 0
    assert main(line) == 0


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--junit", "{place}/no/folder\0"], "no/folder"),
        (["--junit", "{place}"], "cannot be written: Is a directory"),
        (["--baseline", "{place}"], "cannot be written: Is a directory"),
        (["--markdown", "{place}"], "cannot be written: Is a directory"),
        (["--markdown", "-", "--json", "-"], "would mix"),
        (["--update-baseline"], "give --baseline FILE"),
        (["--measure", "--junit", "{place}/x.xml"], "--measure judges nothing"),
        (["--time-limit", "0"], "--time-limit 0: give seconds above 0"),
        (["--memory-limit", "-5"], "--memory-limit -5: give megabytes above 0"),
    ],
)
def test_wrong_input_is_refused_before_anything_runs(
    suites: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    options: list[str],
    told: str,
) -> None:
    given = [word.replace("{place}", str(tmp_path)).replace("\0", "") for word in options]
    if "no/folder" in told:
        (tmp_path / "no").write_text("a file")
        told = "is no folder that can be written to"
    assert main(["stress", "easy", "--file", str(suites), "--seeds", "1", *given]) == 2
    assert told in " ".join(capsys.readouterr().err.split())
    assert not list(tmp_path.glob("*.xml"))

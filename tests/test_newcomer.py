"""A newcomer's way, word for word, in a clean environment."""

import re
from pathlib import Path

import pytest

from benchmarks.newcomer import PAGE, STRESS_PAGE, follow, newcomer_blocks, script_of
from tests.pages import ROOT


def test_the_page_has_all_that_a_newcomer_types() -> None:
    script = script_of(newcomer_blocks(PAGE), "/somewhere")
    assert "git clone /somewhere mot-sim\ncd mot-sim\n" in script
    assert script.index("pip install") < script.index("cat > my_tracker.py")
    assert script.index("cat > my_tracker.py") < script.index("cat > score.py")
    assert script.index("cat > score.py") < script.index("\npython score.py\n")


def test_the_page_of_stress_has_all_up_to_the_junit_file() -> None:
    script = script_of(newcomer_blocks(STRESS_PAGE), "/somewhere")
    assert script.index("pip install") < script.index("cat > following.py")
    command = script[script.index("\nmot-sim stress smoke") :].splitlines()[1].split()
    assert command[-4:] == ["--junit", "stress.xml", "--baseline", "baseline.json"]
    assert "mine=following:forgetful" in command


@pytest.mark.slow
def test_a_newcomer_scores_a_tracker_of_their_own(tmp_path: Path) -> None:
    steps, said = follow(tmp_path, str(ROOT))
    assert re.search(r"MyTracker: HOTA 0\.\d+, \d+ switches", said), said[-2000:]
    assert [step.what for step in steps][1:4] == ["my_tracker.py", "score.py", "python"]

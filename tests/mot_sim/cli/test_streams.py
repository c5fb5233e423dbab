"""The installed command under bad surroundings: pipes that end, full disks, Ctrl-C at once."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from mot_sim.cli.streams import prepare_streams
from mot_sim.files.writing import require_writable, write_lines

SOURCE = Path(__file__).parents[3]
COMMAND = f"{sys.executable} -m mot_sim"


def shell(command: str, folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """A line of bash in a folder, `$MOT` being the command."""
    path = os.pathsep.join([str(SOURCE), os.environ.get("PYTHONPATH", "")])
    surroundings = {**os.environ, "PYTHONPATH": path, "MOT": COMMAND, **environment}
    return subprocess.run(
        ["bash", "-c", command], cwd=folder, env=surroundings, capture_output=True, text=True,
        check=False, timeout=120,
    )  # fmt: skip


def require_one_error(err: str, said: str) -> None:
    """One line on stderr, and it begins so."""
    assert err.startswith(f"error: {said}"), err
    assert err.count("\n") == 1, err


def test_a_reader_that_has_gone_does_not_change_the_exit_code(tmp_path: Path) -> None:
    script = tmp_path / "broken.py"
    script.write_text(
        "import sys\nimport mot_sim.cli.doctor as doctor\nfrom mot_sim.__main__ import main\n"
        "doctor.find_python = lambda: doctor.Check('x', 'broken', '')\nsys.exit(main(['doctor']))\n"
    )
    done = shell(f"{sys.executable} {script} | true; echo ${{PIPESTATUS[0]}}", tmp_path)
    assert (done.stdout, done.stderr) == ("1\n", "")


@pytest.mark.parametrize("target", [">&-", "> /dev/full"])
@pytest.mark.parametrize("command", ["doctor", "--version"])
def test_a_stdout_that_takes_nothing_is_one_line(tmp_path: Path, target: str, command: str) -> None:
    done = shell(f"$MOT {command} {target}", tmp_path)
    require_one_error(done.stderr, "standard output: cannot be written: ")
    assert done.returncode == 2


def test_a_closed_stderr_hides_only_what_would_stand_there(tmp_path: Path) -> None:
    done = shell("$MOT list 2>&- && $MOT track --tracker nobodys --out x 2>&-; echo $?", tmp_path)
    assert "crossing" in done.stdout
    assert done.stdout.endswith("\n2\n")


def test_an_encoding_without_our_characters_gets_plain_ones(tmp_path: Path) -> None:
    done = shell("$MOT list", tmp_path, PYTHONIOENCODING="ascii")
    assert done.returncode == 0, done.stderr
    assert done.stdout.isascii()
    assert "crossing" in done.stdout


@pytest.mark.parametrize("columns", ["0", "-5", "wide"])
def test_columns_that_are_no_width_are_ignored(
    monkeypatch: pytest.MonkeyPatch, columns: str
) -> None:
    monkeypatch.setenv("COLUMNS", columns)
    prepare_streams()
    assert "COLUMNS" not in os.environ


@pytest.mark.parametrize("seconds", [0.05, 0.1, 0.2, 0.4])
def test_an_interrupt_while_the_imports_run_is_one_line(tmp_path: Path, seconds: float) -> None:
    begun = tmp_path / "begun"
    script = tmp_path / "slow.py"
    script.write_text(
        "import pathlib, time, sys\nfrom mot_sim.__main__ import main\n"
        f"pathlib.Path({str(begun)!r}).touch()\nsys.exit(main(['scenes', '--help']))\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(SOURCE)}
    process = subprocess.Popen(
        [sys.executable, script], env=environment, stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    while not begun.exists():
        time.sleep(0.005)
    time.sleep(seconds * 0.2)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert process.returncode in (0, 130), err  # 0: it had finished
    assert err == ("error: interrupted\n" if process.returncode else "")


def test_links_pipes_and_devices_are_written_through(tmp_path: Path) -> None:
    target, link = tmp_path / "deep" / "target.csv", tmp_path / "link.csv"
    target.parent.mkdir()
    target.write_text("old\n")
    link.symlink_to(target)
    write_lines(link, ["new"])
    assert link.is_symlink()
    assert target.read_text() == "new\n"
    require_writable(link)
    for device in ("/dev/null", "/dev/stdout"):
        require_writable(Path(device))
        write_lines(Path("/dev/null"), ["x"])
        assert not Path("/dev/null").is_file()
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with subprocess.Popen(["cat", pipe], stdout=subprocess.PIPE, text=True) as reader:
        write_lines(pipe, ["through"])
        assert reader.communicate(timeout=20)[0] == "through\n"
    assert pipe.is_fifo()
    dangling = tmp_path / "dangling"
    dangling.symlink_to(tmp_path / "later.csv")
    write_lines(dangling, ["there"])
    assert (tmp_path / "later.csv").read_text() == "there\n"


@pytest.mark.parametrize(
    ("name", "made"),
    [("tracker", "tracker.py"), ("tracker", "tracker/__init__.py"), ("scenes", "scenes.py")],
)
def test_a_file_of_the_users_that_hides_ours_is_named(tmp_path: Path, name: str, made: str) -> None:
    file = tmp_path / made
    file.parent.mkdir(exist_ok=True)
    file.write_text("MINE = 1\n")
    said = f"mot-sim's own package '{name}' is hidden by {re.escape(str(file))}: rename"
    for command in ("doctor",):
        done = shell(f"$MOT {command}", tmp_path, PYTHONPATH=f"{tmp_path}:{SOURCE}")
        assert re.match(f"error: {said}", done.stderr), done.stderr
        assert (done.stderr.count("\n"), done.returncode) == (1, 2)
    done = shell(f"{sys.executable} -c 'import mot_sim'", tmp_path,
                 PYTHONPATH=f"{tmp_path}:{SOURCE}")  # fmt: skip
    assert re.search(f"ImportError: {said}", done.stderr)


def test_names_are_shown_as_they_are(tmp_path: Path) -> None:
    done = shell("$MOT stress intersection --trackers 'mine=nomod:X[bold]:car:'", tmp_path)
    assert "nomod:X[bold]:car:" in done.stderr or "X[bold]" in done.stderr, done.stderr


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (
            "sweep --axis detector.jitter=0,1 --axis detector.jitter=2",
            "--axis detector.jitter=2",
        ),
        ("sweep --axis detector.jitter=1 --set rig.height=1 --set rig.height=2", "--set rig.hei"),
        ("record crossing --out x --knobs frames=3,frames=4", "--knobs frames=3,frames=4"),
    ],
)
def test_what_is_said_twice_is_refused(tmp_path: Path, options: str, said: str) -> None:
    done = shell(f"$MOT {options}", tmp_path)
    require_one_error(done.stderr, said)
    assert done.returncode == 2

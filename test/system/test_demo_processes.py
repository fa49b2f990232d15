"""Processes of a demo: whatever ends it, none is left and what was recorded stays."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import pytest

from shoecal_core.recording.session import Session
from shoecal_core.recording.writer import PART
from shoecal_core.workspace import ros_environment

DATA = Path(__file__).parents[1] / "data"
TIMEOUT_S = 240.0
NODES = ("simulator", "shoe_driver", "model", "planner", "calibrator")


class Demo:
    """A demo process and its output."""

    def __init__(self, folder: Path, program: Sequence[str] = ("shoecal_ros.demo",)) -> None:
        self.out = folder / "out"
        self._log = folder / "demo.log"
        # Children that outlive it can be told by this.
        self._mark = f"SHOECAL_TEST_MARK={folder}"
        name, _, value = self._mark.partition("=")
        with self._log.open("wb") as log:
            self.process = subprocess.Popen(
                [
                    sys.executable, "-m", *program,
                    "--out", str(self.out),
                    "--robot", str(DATA / "robots/odd_biped.yaml"),
                    "--shoe", str(DATA / "shoes/odd_shoe.yaml"),
                    "--supports", "3", "--train", "2",
                ],
                env={**ros_environment(), name: value},
                stdout=log,
                stderr=subprocess.STDOUT,
            )  # fmt: skip

    @property
    def output(self) -> str:
        return self._log.read_text()

    def until(self, condition: Callable[[], object]) -> None:
        deadline = time.monotonic() + TIMEOUT_S
        while not condition():
            assert self.process.poll() is None, self.output
            assert time.monotonic() < deadline, self.output
            time.sleep(0.1)

    def end(self) -> int:
        return self.process.wait(TIMEOUT_S)

    def until_gone(self) -> None:
        """Wait until nothing is left of what it has started."""
        deadline = time.monotonic() + TIMEOUT_S
        while self.pids():
            assert time.monotonic() < deadline, self.pids()
            time.sleep(0.1)

    def pids(self) -> dict[int, str]:
        """Every process that descends from it, alive, with its command line."""
        found = {}
        for entry in Path("/proc").iterdir():
            try:
                environment = (entry / "environ").read_bytes().split(b"\0")
                if self._mark.encode() in environment:
                    line = (entry / "cmdline").read_bytes().replace(b"\0", b" ").decode()
                    if line:
                        found[int(entry.name)] = line
            except (OSError, ValueError):
                continue
        return found

    def pid_of(self, node: str) -> int:
        return next(pid for pid, line in self.pids().items() if f"nodes.{node} " in line)


@contextlib.contextmanager
def started(folder: Path, *program: str) -> Iterator[Demo]:
    """A demo of which nothing is left afterwards."""
    demo = Demo(folder, program=program)
    try:
        yield demo
    finally:
        for pid in demo.pids():
            os.kill(pid, signal.SIGKILL)
        demo.process.wait()


@pytest.fixture
def demo(tmp_path: Path) -> Iterator[Demo]:
    with started(tmp_path, "shoecal_ros.demo") as demo:
        yield demo


def test_an_interrupted_demo_leaves_nothing_running(demo: Demo) -> None:
    demo.until(lambda: "moving, run 1 " in demo.output)
    # A thread of its own makes the file.
    demo.until(lambda: list(demo.out.rglob(f"run_*{PART}")))
    demo.process.send_signal(signal.SIGINT)
    assert demo.end() == 130
    assert demo.output.splitlines()[-1] == "demo: interrupted; the nodes have been stopped"
    assert "Traceback" not in demo.output
    assert demo.pids() == {}
    session = Session.open(demo.out / "session")
    assert session.unfinished, "what was recorded stays"


def test_told_to_end_twice_it_ends_as_when_told_once(demo: Demo) -> None:
    demo.until(lambda: "drawing" in demo.output)
    demo.process.send_signal(signal.SIGINT)
    demo.process.send_signal(signal.SIGTERM)
    assert demo.end() == 130
    assert "Traceback" not in demo.output
    demo.until_gone()


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGKILL])
def test_the_command_that_is_ended_ends_all_it_started(
    tmp_path: Path, number: signal.Signals
) -> None:
    """Whatever the signal, and although it reaches the command alone."""
    with started(tmp_path, "shoecal_core.cli", "demo") as demo:
        demo.until(lambda: "drawing" in demo.output)
        assert len(demo.pids()) > len(NODES)
        demo.process.send_signal(number)
        if number == signal.SIGKILL:
            assert demo.end() == -number
            demo.until_gone()
        else:
            assert demo.end() == 130
            assert demo.pids() == {}


def test_a_node_that_dies_is_named(demo: Demo) -> None:
    demo.until(lambda: "reaching, run 1 " in demo.output)
    os.kill(demo.pid_of("model"), signal.SIGKILL)
    assert demo.end() == 1
    assert "node model ended with code -9" in demo.output
    assert demo.pids() == {}


def test_nodes_do_not_outlive_a_killed_demo(demo: Demo) -> None:
    demo.until(lambda: "drawing" in demo.output)
    lines = [line for line in demo.pids().values() if "nodes." in line]
    assert sorted(line.split("nodes.")[1].split()[0] for line in lines) == sorted(NODES)
    demo.process.kill()
    demo.process.wait()
    demo.until_gone()


def test_a_folder_that_is_no_demos_is_not_touched(tmp_path: Path) -> None:
    mine = tmp_path / "out" / "session"
    mine.mkdir(parents=True)
    (mine / "thesis.txt").write_text("years of work")
    demo = Demo(tmp_path)
    assert demo.end() == 1
    assert "choose another folder" in demo.output
    assert (mine / "thesis.txt").read_text() == "years of work"

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from shoecal_ros.demonstration.conductor import Conductor
from shoecal_ros.demonstration.processes import Nodes

DOMAIN = int(os.environ["ROS_DOMAIN_ID"])


@pytest.fixture(autouse=True)
def _handlers_are_given_back() -> Iterator[None]:
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = [signal.getsignal(number) for number in numbers]
    yield
    assert [signal.getsignal(number) for number in numbers] == before


def is_interrupted(folder: Path, work: Callable[[Conductor], None]) -> None:
    """See that a conductor that does some work ends as by Ctrl-C."""
    with pytest.raises(KeyboardInterrupt), Conductor(Nodes(folder, {}), DOMAIN) as conductor:
        work(conductor)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_waits_for_the_next_message_to_be_done(tmp_path: Path, number: int) -> None:
    reached = []

    def work(conductor: Conductor) -> None:
        signal.raise_signal(number)
        reached.append("what was under way")
        conductor.wait_for_nodes()
        reached.append("nodes that nobody has started")

    is_interrupted(tmp_path, work)
    assert reached == ["what was under way"]


def test_one_that_cannot_begin_gives_its_handlers_back(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError, match="Domain id"):
        Conductor(Nodes(tmp_path, {}), -1)


def test_ctrl_c_at_the_very_end_counts(tmp_path: Path) -> None:
    is_interrupted(tmp_path, lambda _: signal.raise_signal(signal.SIGINT))


def test_a_second_ctrl_c_comes_at_once(tmp_path: Path) -> None:
    reached = []

    def work(_: Conductor) -> None:
        signal.raise_signal(signal.SIGINT)
        reached.append("what was under way")
        signal.raise_signal(signal.SIGINT)
        reached.append("more")

    is_interrupted(tmp_path, work)
    assert reached == ["what was under way"]

"""A terminal that stands still, or a reader that has stopped, holds no node up."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator

import pytest

from ros.bodies import NAO, NAO_SHOE
from ros.standing_robot import StandingRobot
from ros.world import World
from shoecal_core.robot.double_support import DoubleSupport


def fill(pipe: int) -> None:
    """Until it takes nothing more."""
    os.set_blocking(pipe, False)
    with contextlib.suppress(BlockingIOError):
        while True:
            os.write(pipe, bytes(4096))
    os.set_blocking(pipe, True)


@pytest.fixture
def full_pipe() -> Iterator[tuple[int, int]]:
    """A pipe that takes nothing more, as a terminal after Ctrl-S."""
    held, into = os.pipe()
    fill(into)
    yield held, into
    os.close(held)
    os.close(into)


def test_a_node_goes_on_and_says_it_once_somebody_reads(
    world: World, full_pipe: tuple[int, int]
) -> None:
    held, into = full_pipe
    world.start("model", {"robot_file": NAO, "shoe_file": NAO_SHOE}, log_to=into)
    # It has something to say by now, and works all the same.
    world.until_reported("model", "joints", "no joint angles yet")
    StandingRobot(world, DoubleSupport(0.02, -0.11, 0.1))
    world.until_reported("model", "joints", "joint angles come")
    said = b""
    while b"joint angles come" not in said:
        said += os.read(held, 65_536)
    assert b"no joint angles yet" in said
    # Again nobody reads. It ends nevertheless.
    fill(into)
    assert world.stop("model") == 0

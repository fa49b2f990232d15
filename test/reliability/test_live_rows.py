"""Rows with real nodes: a few tries of each, not judged by time, and rows that fail."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from shoecal_msgs.srv import SetCalibration

from reliability import cells, peers, stale, wrong_input
from reliability.live_world import Start, World, live_tries, live_world
from reliability.tries import BrokenError
from reliability.wrong_input import Request
from ros.bodies import calibration, nao, nao_shoe
from shoecal_ros.common.conversions import calibration_to_ros


@pytest.mark.parametrize(
    ("start", "tries"),
    [(cells.Scene, (0, 3, 6)), (peers.Scene, (0, 4, 9)), (stale.Scene, range(4))],
)
def test_it_holds(start: Start, tries: Sequence[int]) -> None:
    with live_world() as world:
        scene = start(world)
        for number in tries:
            scene.attempt(number, np.random.default_rng([0, number]))


def test_bad_requests_are_refused_and_a_good_one_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    good = calibration_to_ros(calibration(nao(), nao_shoe()))
    accepted = Request(SetCalibration, "shoe/set_calibration", {"calibration": good}, 0, "good")
    with live_world() as world:
        scene = wrong_input.Scene(world)
        for number in range(55):
            scene.attempt(number, np.random.default_rng([0, number]))
        monkeypatch.setattr(wrong_input, "draw", lambda *_: accepted)
        with pytest.raises(BrokenError, match="good was accepted"):
            scene.attempt(0, np.random.default_rng(0))


class Growing:
    """Its try of a number has that figure; the fifth one breaks."""

    def __init__(self, world: World) -> None:
        del world

    def attempt(self, number: int, rng: np.random.Generator) -> float:
        del rng
        if number == 5:
            raise BrokenError("it broke")
        return float(number)


def test_a_failed_try_ends_the_tries() -> None:
    found = live_tries(Growing, 0, 9, 0, lambda _: None, "{:.0f} s", 8.0)
    assert (found.tried, found.failed, found.worst) == (6, 1, "try 5: it broke")
    found = live_tries(Growing, 0, 5, 0, lambda _: None, "{:.0f} s", 3.0)
    assert (found.tried, found.failed, found.worst) == (5, 1, "try 4: 4 s")
    found = live_tries(Growing, 0, 4, 0, lambda _: None, "{:.0f} s", 3.0)
    assert (found.tried, found.failed, found.worst, found.figure) == (4, 0, "3 s", 3.0)


class Ended(Growing):
    """A node of it ends by itself."""

    def __init__(self, world: World) -> None:
        world.start("calibrator", {"robot_file": world.folder / "none.yaml"}).wait()
        super().__init__(world)


def test_a_node_that_ends_is_a_failed_try() -> None:
    found = live_tries(Ended, 0, 4, 0, lambda _: None)
    assert (found.tried, found.failed) == (4, 1)
    assert "none.yaml" in found.worst

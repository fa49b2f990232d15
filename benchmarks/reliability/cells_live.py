"""Cells that break while a calibrator listens: how soon it says so."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from shoecal_msgs.msg import ShoeState, ShoeVoltages
from shoecal_msgs.srv import GetCalibration, SelfCalibrate

from reliability.live_robots import WaitedForRobot, put_in_force, start_calibrator
from reliability.live_world import World
from ros.bodies import nao_shoe
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import VoltageFrame, time_from_ros

FloatArray = NDArray[np.float64]
Bytes = NDArray[np.uint8]
Spoil = Callable[[int, FloatArray, Bytes], None]
"""Changes voltages and statuses (n,) of the frame that is so many after the fault began."""

NOISE_V = 1e-3
NEWTONS_PER_VOLT = 12.0
RAIL_V = 5.0
BOARD = "hangs with its board"
SPIKE_FRAMES, SLOW_FRAMES = 15, 15
WAIT_S = 60.0
LEARN_S = 5.0
"""In so long a time a cell's own noise is known."""


def off(rng: np.random.Generator, cell: int) -> Spoil:
    """Unplugged: no reading, zero, or the open input at an end of the range."""
    value, status = [
        (np.nan, ShoeVoltages.NO_DATA),
        (0.0, ShoeVoltages.GOOD),
        (RAIL_V, ShoeVoltages.GOOD),
        (-RAIL_V, ShoeVoltages.SATURATED),
    ][int(rng.integers(4))]

    def spoil(frame: int, voltage: FloatArray, statuses: Bytes) -> None:
        del frame
        voltage[cell], statuses[cell] = value, status

    return spoil


def stuck(rng: np.random.Generator, cell: int) -> Spoil:
    """One value, the one that it had."""
    del rng
    held: list[float] = []

    def spoil(frame: int, voltage: FloatArray, statuses: Bytes) -> None:
        del frame, statuses
        held.append(float(voltage[cell]))
        voltage[cell] = held[0]

    return spoil


def board_of(cell: int) -> list[int]:
    """Cells of the board that a cell hangs on: every other time one for its foot, or for all."""
    foot = nao_shoe().foot
    return np.flatnonzero((foot == foot[cell]) | bool(cell % 2)).tolist()


def hung_board(rng: np.random.Generator, cell: int) -> Spoil:
    """All cells of a board as they were, again and again; its counter goes on."""
    del rng
    board = board_of(cell)
    held: list[FloatArray] = []

    def spoil(frame: int, voltage: FloatArray, statuses: Bytes) -> None:
        del frame, statuses
        held.append(voltage[board])
        voltage[board] = held[0]

    return spoil


def saturated(rng: np.random.Generator, cell: int) -> Spoil:
    """At an end of the range, whether the device says so or not."""
    end = RAIL_V * float(rng.choice([-1.0, 1.0]))
    status = int(rng.choice([ShoeVoltages.GOOD, ShoeVoltages.SATURATED]))

    def spoil(frame: int, voltage: FloatArray, statuses: Bytes) -> None:
        del frame
        voltage[cell], statuses[cell] = end, status

    return spoil


def not_a_number(rng: np.random.Generator, cell: int) -> Spoil:
    """NaN or infinite, and said to be good."""
    value = float(rng.choice([np.nan, np.inf, -np.inf]))

    def spoil(frame: int, voltage: FloatArray, statuses: Bytes) -> None:
        del frame, statuses
        voltage[cell] = value

    return spoil


def spikes(rng: np.random.Generator, cell: int) -> Spoil:
    """One to three readings 2 to 40 N off, several a second."""
    size = float(rng.uniform(2.0, 40.0)) * float(rng.choice([-1.0, 1.0])) / NEWTONS_PER_VOLT
    length = int(rng.integers(1, 4))

    def spoil(frame: int, voltage: FloatArray, statuses: Bytes) -> None:
        del statuses
        if frame % SPIKE_FRAMES < length:
            voltage[cell] += size

    return spoil


def slow(rng: np.random.Generator, cell: int) -> Spoil:
    """A new reading every 0.15 s only."""
    del rng
    held: list[float] = []

    def spoil(frame: int, voltage: FloatArray, statuses: Bytes) -> None:
        del statuses
        if frame % SLOW_FRAMES == 0:
            held.append(float(voltage[cell]))
        voltage[cell] = held[-1]

    return spoil


LIVE: Mapping[str, Callable[[np.random.Generator, int], Spoil]] = {
    "off": off,
    "stuck": stuck,
    "saturated": saturated,
    "NaN": not_a_number,
    "spikes": spikes,
    "slow": slow,
    BOARD: hung_board,
}
"""Faults that show while they happen."""


class SpoiltRobot(WaitedForRobot):
    """Its cells are noisy, and one may be broken.

    Attributes:
        broken_at: when the first spoilt frame was sent, monotonic [s].
        broken_ns: its own stamp.
    """

    def __init__(self, world: World) -> None:
        self._noise = np.random.default_rng(1)
        self._spoil: Spoil | None = None
        self._spoilt = 0
        self.broken_at, self.broken_ns = 0.0, 0
        super().__init__(world)

    def spoil(self, change: Spoil | None) -> None:
        """Break a cell from the next frame on, or mend it."""
        self._spoil, self._spoilt = change, 0

    def _frame(self) -> VoltageFrame:
        frame = super()._frame()
        voltage = frame.voltage + NOISE_V * self._noise.standard_normal(len(frame.voltage))
        status = frame.status.copy()
        if self._spoil is not None:
            if self._spoilt == 0:
                self.broken_at, self.broken_ns = time.monotonic(), frame.stamp_ns
            self._spoil(self._spoilt, voltage, status)
            self._spoilt += 1
        return replace(frame, voltage=voltage, status=status)


@dataclass(frozen=True)
class Told:
    """What the calibrator said of a broken cell.

    Attributes:
        after: from the first spoilt frame to the state that names it, and its board's others [s].
        readings_s: the same by the robot's own stamps, up to the last reading that the calibrator
            had by then: what a busy machine takes for a message does not count [s].
        alone: no others.
    """

    after: float
    readings_s: float
    alone: bool


class LiveCells:
    """A calibrator in force beside a robot whose cells break."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.robot = SpoiltRobot(world)
        self._states: list[tuple[float, ShoeState]] = []
        world.node.create_subscription(
            ShoeState,
            "shoe/state",
            lambda state: self._states.append((time.monotonic(), state)),
            qos.LATCHED,
        )
        start_calibrator(world)
        put_in_force(world)
        self._until(_well)

    def calibrate(self) -> None:
        """Begin a self-calibration, which waits for its first double support."""
        request = SelfCalibrate.Request(seed=-1)
        answer = self.world.call(SelfCalibrate, "shoe/self_calibrate", request)
        assert answer.accepted, answer.message
        self.world.until(lambda: self.robot.waited_for > 0, timeout_s=120.0)

    def break_cell(self, fault: str, cell: int, rng: np.random.Generator) -> Told:
        """Break a cell, hear what is said, mend it."""
        self._until(_well)
        self._wait(float(rng.uniform(0.8, 1.2)) + (LEARN_S if fault == BOARD else 0.0))
        self._states.clear()
        broken = board_of(cell) if fault == BOARD else [cell]
        self.robot.spoil(LIVE[fault](rng, cell))
        try:
            at, state = self._until(lambda one: _broken(one, broken))
            self._wait(0.3)
            everything = [one for _, one in self._states]
        finally:
            self.robot.spoil(None)
        others = [set(np.flatnonzero(_statuses(one))) - set(broken) for one in everything]
        readings_ns = time_from_ros(state.header.stamp) - self.robot.broken_ns
        return Told(at - self.robot.broken_at, readings_ns / 1e9, alone=not any(others))

    def in_force(self) -> str:
        """Id of the calibration in force."""
        found = self.world.call(GetCalibration, "shoe/get_calibration", GetCalibration.Request())
        return str(found.calibration.id)

    def _until(self, condition: Callable[[ShoeState], bool]) -> tuple[float, ShoeState]:
        """The first state that meets a condition, and when it came."""
        self.world.until(lambda: any(condition(one) for _, one in self._states), WAIT_S)
        return next((at, one) for at, one in self._states if condition(one))

    def _wait(self, seconds: float) -> None:
        end = time.monotonic() + seconds
        self.world.until(lambda: time.monotonic() >= end)


def _statuses(state: ShoeState) -> list[int]:
    """Of all cells, in the shoe's order."""
    return [int(status) for foot in state.feet for status in foot.status]


def _broken(state: ShoeState, cells: Sequence[int]) -> bool:
    feet = [state.feet[foot] for foot in set(nao_shoe().foot[cells].tolist())]
    told = all(_statuses(state)[cell] for cell in cells)
    return told and not any(foot.valid or foot.stale for foot in feet)


def _well(state: ShoeState) -> bool:
    return all(foot.valid and not any(foot.status) for foot in state.feet)

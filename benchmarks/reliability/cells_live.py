"""Cells that break while a calibrator listens: how soon it reports them."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from shoecal_msgs.action import Calibrate
from shoecal_msgs.msg import ShoeState, ShoeVoltages
from shoecal_msgs.srv import GetCalibration

from reliability.live_robots import WaitedForRobot, start_calibrator
from reliability.live_world import World, wait
from reliability.tries import BrokenError
from ros.bodies import nao_shoe
from shoecal_core.arrays import FloatArray
from shoecal_ros.common import qos
from shoecal_ros.common.voltage_frame import VoltageFrame

Bytes = NDArray[np.uint8]
Spoil = Callable[[int, FloatArray, Bytes], None]
"""Changes voltages and statuses (n,) of the frame that is so many after the fault began."""

NOISE_V = 1e-3
NEWTONS_PER_VOLT = 12.0
RAIL_V = 5.0
SPIKE_FRAMES, SLOW_FRAMES = 15, 15
WAIT_S = 60.0
LEARN_S = 5.0
"""In so long a time a cell's own noise is known."""

NO_DATA, GOOD, SATURATED = ShoeVoltages.NO_DATA, ShoeVoltages.GOOD, ShoeVoltages.SATURATED
CONSTANT = {
    "off": ((np.nan, NO_DATA), (0.0, GOOD), (RAIL_V, GOOD), (-RAIL_V, SATURATED)),
    "saturated": tuple((end, one) for end in (-RAIL_V, RAIL_V) for one in (GOOD, SATURATED)),
    "NaN": ((np.nan, GOOD), (np.inf, GOOD), (-np.inf, GOOD)),
}
"""Faults of one value [V], with the status that the device gives it."""
BOARD = "hangs with its board"
HELD = {"stuck": 10**9, "slow": SLOW_FRAMES, BOARD: 10**9}
"""Faults that hold readings, and after how many frames the next one comes."""
LIVE = (*CONSTANT, *HELD, "spikes")
"""Faults that show while they happen."""


def broken_cells(fault: str, cell: int) -> list[int]:
    """Cells that break: all of a board, every other time one for the foot or for both feet."""
    foot = nao_shoe().foot
    board = np.flatnonzero((foot == foot[cell]) | bool(cell % 2)).tolist()
    return board if fault == BOARD else [cell]


def spoil(fault: str, cells: Sequence[int], rng: np.random.Generator) -> Spoil:
    """A fault of some cells."""
    if fault in CONSTANT:
        return _constant(cells, *CONSTANT[fault][rng.integers(len(CONSTANT[fault]))])
    return _held(cells, HELD[fault]) if fault in HELD else _spikes(cells, rng)


def _constant(cells: Sequence[int], value: float, status: int) -> Spoil:
    def change(frame: int, voltage: FloatArray, statuses: Bytes) -> None:
        del frame
        voltage[cells], statuses[cells] = value, status

    return change


def _held(cells: Sequence[int], frames: int) -> Spoil:
    held = np.zeros(len(cells))

    def change(frame: int, voltage: FloatArray, statuses: Bytes) -> None:
        del statuses
        if frame % frames == 0:
            held[:] = voltage[cells]
        voltage[cells] = held

    return change


def _spikes(cells: Sequence[int], rng: np.random.Generator) -> Spoil:
    """One to three readings 2 to 40 N off, several a second."""
    size = float(rng.uniform(2.0, 40.0)) * float(rng.choice([-1.0, 1.0])) / NEWTONS_PER_VOLT
    length = int(rng.integers(1, 4))

    def change(frame: int, voltage: FloatArray, statuses: Bytes) -> None:
        del statuses
        if frame % SPIKE_FRAMES < length:
            voltage[cells] += size

    return change


class SpoiltRobot(WaitedForRobot):
    """Its cells are noisy, and some may be broken.

    Attributes:
        broken_at: when the first spoilt frame was sent, monotonic [s].
    """

    def __init__(self, world: World) -> None:
        self._noise = np.random.default_rng(1)
        self._spoil: Spoil | None = None
        self._spoilt = 0
        self.broken_at = 0.0
        super().__init__(world)

    def break_cells(self, change: Spoil | None) -> None:
        """Break cells from the next frame on, or correct them."""
        self._spoil, self._spoilt = change, 0

    def _frame(self) -> VoltageFrame:
        frame = super()._frame()
        voltage = frame.voltage + NOISE_V * self._noise.standard_normal(len(frame.voltage))
        status = frame.status.copy()
        if self._spoil is not None:
            if self._spoilt == 0:
                self.broken_at = time.monotonic()
            self._spoil(self._spoilt, voltage, status)
            self._spoilt += 1
        return replace(frame, voltage=voltage, status=status)


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
        self._before = self._in_force()

    @contextmanager
    def calibrating(self) -> Iterator[None]:
        """A self-calibration, which waits for its first double support."""
        waited_for = self.robot.waited_for
        self._until_well()
        goal = self.world.goal(Calibrate, "shoe/calibrate", Calibrate.Goal(seed=-1))
        self.world.until(lambda: goal.done or self.robot.waited_for > waited_for)
        assert not goal.done, goal.result().message
        yield
        goal.cancel()
        goal.result()

    def break_cell(self, fault: str, cell: int, rng: np.random.Generator) -> float:
        """Break a cell and mend it; time from the first spoilt frame to the state [s].

        Raises:
            BrokenError: when another cell is reported, or another calibration comes in force.
        """
        self._until_well()
        wait(self.world, float(rng.uniform(0.8, 1.2)) + (LEARN_S if fault == BOARD else 0.0))
        self._states.clear()
        broken = broken_cells(fault, cell)
        self.robot.break_cells(spoil(fault, broken, rng))
        try:
            at = self._until(lambda state: _broken(state, broken))
            wait(self.world, 0.3)
        finally:
            self.robot.break_cells(None)
        if any(np.delete(_statuses(state), broken).any() for _, state in self._states):
            raise BrokenError(f"{fault}: not only {broken} were reported")
        if self._in_force() != self._before:
            raise BrokenError(f"{fault}: another calibration came in force")
        return at - self.robot.broken_at

    def _in_force(self) -> str:
        found = self.world.call(GetCalibration, "shoe/get_calibration", GetCalibration.Request())
        return str(found.calibration.id)

    def _until_well(self) -> None:
        self._states.clear()
        self._until(lambda state: all(foot.valid and not any(foot.status) for foot in state.feet))

    def _until(self, condition: Callable[[ShoeState], bool]) -> float:
        """When the first state came that meets a condition."""
        self.world.until(lambda: any(condition(one) for _, one in self._states), WAIT_S)
        return next(at for at, one in self._states if condition(one))


def _statuses(state: ShoeState) -> list[int]:
    """Of all cells, in the shoe's order."""
    return [int(status) for foot in state.feet for status in foot.status]


def _broken(state: ShoeState, cells: Sequence[int]) -> bool:
    feet = [state.feet[foot] for foot in set(nao_shoe().foot[cells].tolist())]
    reported = all(_statuses(state)[cell] for cell in cells)
    return reported and not any(foot.valid or foot.stale for foot in feet)

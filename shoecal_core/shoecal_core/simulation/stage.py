"""One stage on the way of a signal from the force on a channel to its converter."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, ClassVar, Generic, TypeVar

from shoecal_core.arrays import FloatArray

State = TypeVar("State")


class Place(IntEnum):
    """Where on the way a stage sits: the physics sets their order, not a file."""

    PLATE = 0
    """Forces reach the cells."""
    FRICTION = 1
    FLOW = 2
    """The cell's body and glue give way slowly."""
    CURVE = 3
    """What it gives for a force is no straight line."""
    STOP = 4
    """It has an end."""
    SPAN = 5
    ZERO = 6
    CABLE = 7
    """Channels see each other."""
    CONTACT = 8
    """A loose contact."""
    SOCKET = 9
    """A plug in the wrong one."""
    FILTER = 10
    """What the converter's input does to fast signals."""


@dataclass(frozen=True)
class Instant:
    """The surroundings of all channels at one instant of a session.

    Attributes:
        time: since the session began [s].
        span: since the instant before [s]; 0 at the first.
        sideways: (2, 2) the floor's force on left, right along x and y of its sole frame [N].
        run: of the session, from 1; 0 before the first.
    """

    time: float
    span: float
    sideways: FloatArray
    run: int


class Stage(ABC, Generic[State]):
    """A stage; what it remembers is handed from instant to instant, never kept in it.

    So an instant can be looked at without changing what comes after it.
    """

    place: ClassVar[Place]
    feels_sideways: ClassVar[bool] = False
    """Whether it needs the floor's sideways forces."""

    @abstractmethod
    def start(self) -> State:
        """What it remembers of channels that never carried anything."""

    @abstractmethod
    def __call__(
        self, signal: FloatArray, state: State, instant: Instant
    ) -> tuple[FloatArray, State]:
        """Pass a signal (n,) [N or N m] on, and what to remember."""


AnyStage = Stage[Any]


class Memoryless(Stage[None]):
    """A stage that remembers nothing."""

    def start(self) -> None:
        """Nothing."""

    def __call__(
        self, signal: FloatArray, state: None, instant: Instant
    ) -> tuple[FloatArray, None]:
        """Pass a signal (n,) on."""
        return self.passed(signal, instant), state

    @abstractmethod
    def passed(self, signal: FloatArray, instant: Instant) -> FloatArray:
        """The signal (n,) behind this stage [N or N m]; the one before it stays as it is."""

"""Joint angles as they come, in the robot's own order; says what is wrong with them."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.errors import ShoecalError
from shoecal_core.robot.robot import Robot
from shoecal_ros.common.codes import Code, Problem
from shoecal_ros.common.conversions import time_from_ros
from shoecal_ros.inputs.arrival_monitor import SILENT_S, ArrivalMonitor
from shoecal_ros.inputs.one_sender import OneSender

ASK_S = 0.1
"""From one look for who sends to the next, while they contradict each other."""


class UnusableJointsError(ShoecalError):
    """Joint angles of which nothing can be made."""


@dataclass(frozen=True)
class JointBatch:
    """Angles of T instants.

    Attributes:
        stamp_ns: (T,) times of sampling.
        angles: (T, m) of all the robot's joints [rad].
    """

    stamp_ns: IntArray
    angles: FloatArray


class JointInput:
    """What a robot reports of its joints.

    Attributes:
        problem: what is wrong and its cure, None while usable angles come often enough.
        latest: the last usable angles, None before there were any.
        heard: since when there were none.
    """

    def __init__(
        self,
        robot: Robot,
        stale_s: float,
        clock: Callable[[], float] = time.monotonic,
        *,
        silent_s: float = SILENT_S,
        senders: Callable[[], Sequence[str]] = tuple,
    ) -> None:
        """Nothing heard.

        Args:
            robot: whose joints.
            stale_s: without usable angles for that long there is a problem, by the wall clock [s].
            clock: monotonic [s].
            silent_s: for that long at least, they are silent [s].
            senders: names of the nodes that send joint angles, to be reported.
        """
        self.robot = robot
        self.latest: JointBatch | None = None
        self._stale_s = stale_s
        self._clock = clock
        self.heard = ArrivalMonitor(clock, silent_s)
        self._senders = senders
        self._sender = OneSender(robot)
        self._mismatch: Problem | None = None
        self._contradicted = False
        self._contradicting: Sequence[str] = ()
        self._asked_s = -math.inf

    @property
    def fresh(self) -> bool:
        """Whether usable angles have come lately enough to go on."""
        return self.heard.age_s <= self._stale_s and not self._contradicted

    @property
    def silent(self) -> bool:
        """Whether nothing may be made of the last angles any more: none come, or two send them."""
        return self._contradicted or self.heard.silent

    @property
    def problem(self) -> Problem | None:
        """What is wrong; of messages that cannot be used only once angles are stale."""
        if self.fresh:
            return None
        if self._contradicted:
            return Problem(Code.JOINTS_CONTRADICT, self._who_contradicts())
        if self._mismatch:
            return self._mismatch
        if self.latest is None:
            reported = "no joint angles yet; start the robot's driver (joint_states)"
            return Problem(Code.NO_JOINTS, reported)
        reported = f"no joint angles for {self.heard.age_s:.0f} s; check the robot's driver"
        return Problem(Code.JOINTS_STALE, reported)

    def refuse(self, problem: Problem) -> None:
        """What came last could not be used."""
        self._mismatch = problem

    def take(self, messages: Sequence[Any]) -> JointBatch | None:
        """Take JointState messages in order; usable angles, None where there are none."""
        stamps: list[int] = []
        parts: list[FloatArray] = []
        for names, group in groupby(messages, key=lambda message: message.name):
            same = list(group)
            try:
                angles = self._angles(names, [message.position for message in same])
            except ShoecalError as error:
                self.refuse(Problem.of(error))
                continue
            self._mismatch = None
            parts.append(angles)
            stamps += [time_from_ros(message.header.stamp) for message in same]
        if not parts:
            return None
        batch = self._usable(np.array(stamps, dtype=np.int64), np.concatenate(parts))
        if batch is None:
            return None
        self.latest = JointBatch(batch.stamp_ns[-1:], batch.angles[-1:])
        self.heard.note(len(batch.stamp_ns))
        return batch

    def _usable(self, stamps: IntArray, angles: FloatArray) -> JointBatch | None:
        """What one sender sent, each later than all before it; a clock may have been set back."""
        if not stamps.any():
            reported = "joint_states carries no stamps of time; correct its sender"
            self._mismatch = Problem.of(UnusableJointsError(reported))
            return None
        keep = self._sender.follows(stamps, angles)
        self._contradicted = self._sender.doubled
        if not self._contradicted:
            self._contradicting, self._asked_s = (), -math.inf
        elif self._clock() - self._asked_s >= ASK_S:
            self._contradicting, self._asked_s = self._those_who_send(), self._clock()
        if self._contradicted or not keep.any():
            return None
        return JointBatch(stamps[keep], angles[keep])

    def _those_who_send(self) -> Sequence[str]:
        """By name; where there were more, those who are left are not what was wrong."""
        # Asked again and again: one that has just come may not have its name yet.
        names = tuple(self._senders())
        return names if len(names) >= len(self._contradicting) else self._contradicting

    def _who_contradicts(self) -> str:
        names = [f"'{name}'" for name in self._contradicting]
        if len(names) > 1:
            return (
                f"joint angles run to and fro between {' and '.join(names)}; stop all but one "
                "sender of joint_states"
            )
        return (
            f"joint angles run to and fro{f', all from {names[0]}' if names else ''}; let one node "
            "alone send joint_states, and check the robot's encoders"
        )

    def _angles(self, names: list[str], positions: Sequence[Sequence[float]]) -> FloatArray:
        for row in positions:
            if len(row) != len(names):
                raise UnusableJointsError(
                    f"joint_states: {len(row)} positions for {len(names)} names; correct its sender"
                )
        angles = self.robot.from_measured(names, np.array(positions, dtype=np.float64))
        missing = ~np.isfinite(angles).all(axis=0)
        if missing.any():
            reported = ", ".join(np.array(self.robot.joint_names)[missing])
            raise UnusableJointsError(
                f"joint_states: no number for joint(s) {reported}; check the robot's driver, or "
                "list them under 'optional_joints' of the robot file"
            )
        return angles

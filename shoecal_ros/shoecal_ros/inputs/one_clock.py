"""Are joint angles and voltages stamped by one clock? Else forces would meet other postures."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from shoecal_ros.common.codes import Code, Problem
from shoecal_ros.inputs.joints import JointInput
from shoecal_ros.inputs.voltages import VoltageInput

TOGETHER_S = 0.3
"""Stamps of what came within this wall-clock time can be compared."""
APART_S = 2.0
"""Stamps that stay apart for so long are of two clocks: a busy computer hears one of both late."""


class OneClock:
    """Compares the last stamps of both; to be asked all the time."""

    def __init__(
        self,
        joints: JointInput,
        voltages: VoltageInput,
        gap_s: float,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Nothing has been compared.

        Args:
            joints: what the robot sends.
            voltages: what the shoes send.
            gap_s: by which their stamps may differ [s].
            clock: monotonic [s].
        """
        self._joints = joints
        self._voltages = voltages
        self._gap_s = gap_s
        self._clock = clock
        self._apart_since = math.inf

    @property
    def problem(self) -> Problem | None:
        """What is wrong and its cure; None while one clock is at work, or nothing comes."""
        latest, stamp_ns = self._joints.latest, self._voltages.latest_ns
        if latest is None or stamp_ns is None:
            return None
        if max(self._joints.heard.age_s, self._voltages.heard.age_s) > TOGETHER_S:
            # What comes seldom is compared now and then; a silence is nothing that was compared.
            if self._joints.heard.silent or self._voltages.heard.silent:
                self._apart_since = math.inf
            return None
        gap_s = abs(int(latest.stamp_ns[0]) - stamp_ns) / 1e9
        if gap_s <= self._gap_s:
            self._apart_since = math.inf
            return None
        now = self._clock()
        self._apart_since = min(self._apart_since, now)
        if now - self._apart_since <= APART_S:
            return None
        return Problem(
            Code.CLOCKS_APART,
            f"stamps of joint angles and voltages are {gap_s:.1f} s apart; let both senders "
            "use one clock",
        )

"""Samples that are stamped on receipt, packet by packet: their stamps are not when they were taken.

A board or a driver gathers samples and sends them together. Stamped as they arrive, all but the
last of a packet are late by up to the time from one packet to the next.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray

SHORT, MOSTLY = 0.5, 0.5
"""Steps below that share of the mean one are within a packet; from that share of all steps on
samples come in packets. Stamps of random arrival have 0.4, sound recordings 0.0."""
LEAST_PACKETS = 10
FILLED = 0.25
"""A packet's stamps take less of the time until the next one: what takes more was sampled then,
with gaps in the recording."""
REGULAR = 0.5
"""Most packets come at that share of their usual distance, or closer: gaps in a recording do not.
"""
READINGS_S = 0.2
"""Packets of readings that come faster are harmless: readings are then off by half of it, 0.1 s, to
either side, and that evens out. Measured on a NAO that moves slowly, against the calibration of
even stamps: its CoP moves by 0.4 mm RMS or less at 0.04, 0.1 and 0.2 s alike."""
ANGLES_S = 0.1
"""The same of joint angles, between which longer gaps are not interpolated."""


@dataclass(frozen=True)
class Packets:
    """How samples come: so many in each, one packet every so often [s].

    Attributes:
        first: place of the first sample of the second packet.
    """

    size: int
    apart: float
    first: int

    def describe(self, what: str) -> str:
        """The fault and its cure; `what` comes so: "readings"."""
        return (
            f"{what} come in packets of {self.size} every {self.apart:.2f} s, stamped when "
            f"received, up to {self.apart:.2f} s after they were taken: stamp them where they are "
            "sampled (by a clock or counter of the board), or spread the stamps of each packet "
            "evenly over the time since the one before"
        )


def find_packets(time: FloatArray, bearable_s: float) -> Packets | None:
    """Packets in which samples come; None where they are no further apart than is bearable.

    Args:
        time: (T,) of the samples, increasing [s].
        bearable_s: READINGS_S or ANGLES_S.
    """
    steps = np.diff(time)
    if len(steps) < LEAST_PACKETS:
        return None
    inside = steps < SHORT * steps.mean()
    starts = np.flatnonzero(~inside) + 1
    if inside.mean() <= MOSTLY or len(starts) <= LEAST_PACKETS:
        return None
    apart = np.diff(time[starts])
    usual = float(np.median(apart))
    spans = time[starts[1:] - 1] - time[starts[:-1]]
    regular = np.abs(apart - usual) <= REGULAR * usual
    if usual <= bearable_s or np.median(spans) > FILLED * usual or regular.mean() <= MOSTLY:
        return None
    return Packets(round(float(np.median(np.diff(starts)))), usual, int(starts[0]))

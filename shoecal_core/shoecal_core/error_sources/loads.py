"""What shoes and joints bear, by the channels under one set of gains and offsets."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources import body
from shoecal_core.error_sources.wiring import Wiring
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.samples.filters import play
from shoecal_core.samples.samples import Samples, Track
from shoecal_core.shoe.wrench import ChannelParameters, combined, weight_below

LOOP_WIDTHS = (0.1, 0.2, 0.3)
"""Widths of plays, over the range of a channel's output in a motion."""


@dataclass(frozen=True)
class Loads:
    """Forces and torques at T samples.

    Attributes:
        samples: of the session.
        parameters: gains and offsets.
        wiring: of the channels.
    """

    samples: Samples
    parameters: ChannelParameters
    wiring: Wiring

    @cached_property
    def outputs(self) -> FloatArray:
        """(T, n) [N or N m]."""
        return self.parameters.outputs(self.samples.readings)

    @property
    def supports(self) -> tuple[DoubleSupport, ...]:
        """Where the right foot stands in each segment, from the joints."""
        return self.samples.supports

    @cached_property
    def columns(self) -> FloatArray:
        """(segments, n, 3) of every channel in the stance's frame, those in the air zero."""
        stacked = []
        for segment, support in enumerate(self.supports):
            left, right = self.samples.standing[segment]
            both = left and right
            wiring = self.wiring
            stacked.append(wiring.in_left(support) if both else wiring.of_foot(0 if left else 1))
        return np.array(stacked)

    @cached_property
    def per_sample(self) -> FloatArray:
        """(T, n, 3) the same, of each sample."""
        return self.columns[self.samples.segment]

    @cached_property
    def foot_wrenches(self) -> FloatArray:
        """(T, 2, 3) of each foot in its sole frame [N, N m]."""
        each = [self.outputs @ self.wiring.of_foot(foot) for foot in (0, 1)]
        return np.stack(each, axis=1) + weight_below(self.samples.shoe)

    @cached_property
    def wrench(self) -> FloatArray:
        """(T, 3) on all feet that stand, in the stance's frame [N, N m]."""
        base = weight_below(self.samples.shoe)
        fixed = []
        for segment, support in enumerate(self.supports):
            left, right = self.samples.standing[segment]
            fixed.append(combined(base, support) if left and right else base[0 if left else 1])
        found: FloatArray = (
            np.einsum("tn,tnw->tw", self.outputs, self.per_sample)
            + np.array(fixed)[self.samples.segment]
        )
        return found

    @cached_property
    def cop(self) -> FloatArray:
        """(T, 2) measured, in the stance's frame [m]."""
        force = np.maximum(self.wrench[:, 0], 0.2 * self.samples.force)
        place: FloatArray = np.stack((-self.wrench[:, 2], self.wrench[:, 1]), axis=1)
        return place / force[:, None]

    @cached_property
    def loops(self) -> list[FloatArray]:
        """(T, n) what plays of several widths make of the outputs, a unit of width; each less them.

        A play of width w, turned round, makes a loop w high. Loops are as high as the ranges are
        wide that motions go through, so that widths are over these: a foot that was in the air
        once has seen a far larger range, but only once.
        """
        span = self.usual_range

        def loop(width: float) -> FloatArray:
            def work(track: Track) -> FloatArray:
                force = self.parameters.outputs(track.readings)
                return (play(force, width * span) - force) / width

            return self.samples.decimated(work)

        return [loop(width) for width in LOOP_WIDTHS]

    @property
    def usual_range(self) -> FloatArray:
        """(n,) of the outputs in the median run, while both feet stand [N or N m]."""
        samples = self.samples
        ranges = [
            np.ptp(self.outputs[here], axis=0)
            for run in samples.runs
            if np.any(here := samples.both & (samples.run == run))
        ]
        usual: FloatArray = np.median(ranges or [np.ptp(self.outputs, axis=0)], axis=0)
        return usual

    @cached_property
    def links(self) -> body.Links:
        """Places of the links, and torques."""
        return body.links(self.samples, self.foot_wrenches)

    @cached_property
    def torque(self) -> FloatArray:
        """(T, m) that the joints hold with [N m].

        As the robot reports it, where it does; of joints on one motor it reports only the sum, so
        these and all others are what the vertical forces on the feet require.
        """
        samples = self.samples
        torque = self.links.torque.copy()
        if samples.efforts is not None:
            shared = {one for pair in samples.robot.shared for one in (pair.joint, pair.leader)}
            own = [joint for joint in samples.robot.moved.tolist() if joint not in shared]
            torque[:, own] = samples.efforts[:, own]
        return torque

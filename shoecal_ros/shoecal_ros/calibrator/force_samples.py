"""One message a sample with all that a controller needs: `shoe/forces`.

Wrenches are six numbers, force x, y, z [N] and torque x, y, z [N m] about a frame's origin. NaN
stands for an axis that nothing measures.

Covariances are those that `StatedError` states, as reports do, with the readings' own noise.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from geometry_msgs.msg import Point, Vector3, Wrench
from shoecal_msgs.msg import FootForce, ShoeForces

from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.estimation.uncertainty.stated_error import (
    StatedError,
    StatedSample,
    StatedWrench,
    Turns,
    turns_to,
)
from shoecal_core.robot.kinematics import BodyStates
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import FEET, Shoe
from shoecal_ros.calibrator.live import FootFlags, Live, wrench_of
from shoecal_ros.calibrator.load import LEFT, RIGHT
from shoecal_ros.common.conversions import header_to_ros

STANCE = "stance"
SUM_FRAMES = (STANCE, *FEET)
"""Frame of the sum: of the foot that carries, as `shoe/cop`; or always of one foot."""
FLAT = 0.02
"""rad; soles that are tilted further against each other share no floor."""
VERTICAL = [2, 3, 4]
"""Force z, torque x, torque y: what cells measure."""
UNKNOWN: FloatArray = np.full((3, 3), np.nan)
Spread = tuple[FloatArray, FloatArray]
"""(3, 3) covariance of F, Mx, My, and (2, 2) of the CoP."""
NOTHING: Spread = (UNKNOWN, UNKNOWN[:2, :2])


@dataclass(frozen=True)
class _Soles:
    """How the soles lie to each other.

    Attributes:
        turn: (3, 3) turns vectors of the right sole's frame into the left's.
        shift: (3,) origin of the right sole in the left sole's frame [m].
        flat: whether both lie on one floor.
        to: for each target foot what takes both feet's F, Mx, My into its sole's frame.
    """

    turn: FloatArray
    shift: FloatArray
    flat: bool
    to: tuple[Turns, Turns]

    @classmethod
    def of(cls, states: BodyStates) -> _Soles:
        """In the last sample."""
        turn, support = states.rotation[-1], states.support()
        return cls(
            turn=turn,
            shift=states.translation[-1],
            flat=math.acos(min(1.0, abs(float(turn[2, 2])))) < FLAT,
            to=(turns_to(support, LEFT), turns_to(support, RIGHT)),
        )

    def moved(self, place: FloatArray, source: int, target: int) -> FloatArray:
        """A point (3,) [m] of one sole's frame in another's."""
        if (source, target) == (RIGHT, LEFT):
            place = self.turn @ place + self.shift
        elif (source, target) == (LEFT, RIGHT):
            place = self.turn.T @ (place - self.shift)
        return place


class ForceSamples:
    """Makes the messages under one calibration."""

    def __init__(
        self,
        calibration: Calibration,
        robot: Robot,
        shoe: Shoe,
        tolerances: Tolerances,
        soles: tuple[str, str],
        sum_frame: str,
    ) -> None:
        """Under a calibration.

        Args:
            calibration: in force.
            robot: on the shoe.
            shoe: with its channels.
            tolerances: of both.
            soles: names of their frames.
            sum_frame: one of SUM_FRAMES.
        """
        self._id = calibration.id
        self._soles = soles
        self._fixed = None if sum_frame == STANCE else FEET.index(sum_frame)
        self._law = calibration.parameters
        self._sideways = [_sideways(shoe, foot) for foot in range(len(FEET))]
        self._stated = StatedError.of_calibration(calibration, robot, shoe, tolerances)
        # Joint angles come less often than readings.
        self._states: BodyStates | None = None
        self._between: _Soles | None = None

    def message(
        self,
        live: Live,
        flags: Sequence[FootFlags],
        states: BodyStates | None,
        noise: FloatArray,
    ) -> ShoeForces:
        """One sample.

        Args:
            live: both feet.
            flags: of each foot.
            states: of the body, one sample; None where joint angles are stale.
            noise: (n,) standard deviations of the readings.
        """
        if states is not self._states:
            self._states = states
            self._between = None if states is None else _Soles.of(states)
        stated = None if self._stated is None else self._stated.at(live.readings, noise)
        forces = [self._sideways_force(foot, live.readings) for foot in (LEFT, RIGHT)]
        feet = [self._foot(foot, live, flags[foot], forces[foot], stated) for foot in (LEFT, RIGHT)]
        both = self._both(live, flags, forces, stated)
        return ShoeForces(
            header=header_to_ros(live.stamp_ns, both.frame_id),
            calibration=self._id,
            left=feet[LEFT],
            right=feet[RIGHT],
            both=both,
        )

    # One foot, and both

    def _foot(
        self,
        foot: int,
        live: Live,
        flags: FootFlags,
        sideways: FloatArray,
        stated: StatedSample | None,
    ) -> FootForce:
        own = live.feet[foot]
        wrench = np.full(6, np.nan)
        wrench[:2] = sideways
        wrench[2] = own.force
        place = None
        if own.cop is not None:
            wrench[VERTICAL] = wrench_of(own)
            place = (*own.cop, 0.0)
        spread = NOTHING if stated is None else _spread(stated.foot(foot))
        message = _message(self._soles[foot], wrench, place, spread)
        message.loaded, message.stale = flags.loaded, flags.stale
        message.valid, message.extrapolating = flags.valid, flags.extrapolating
        return message

    def _both(
        self,
        live: Live,
        flags: Sequence[FootFlags],
        sideways: Sequence[FloatArray],
        stated: StatedSample | None,
    ) -> FootForce:
        target = live.frame if self._fixed is None else self._fixed
        wrench, place, spread = np.full(6, np.nan), None, NOTHING
        between = self._between
        if between is not None and live.wrench is not None:
            to_target = between.to[target]
            if between.flat or target == live.frame:
                wrench[VERTICAL] = to_target[live.frame] @ np.array(live.wrench)
                if not any(live.loaded):
                    wrench[3:5] = np.nan
            if between.flat:
                if stated is not None:
                    spread = _spread(stated.both(to_target, target))
                turns = [one[1:, 1:] for one in to_target]
                wrench[:2] = sum(turn @ one for turn, one in zip(turns, sideways, strict=True))
            if live.cop is not None:
                ground = np.array([*live.cop, 0.0])
                place = between.moved(ground, live.frame, target).tolist()
        message = _message(self._soles[target], wrench, place, spread)
        message.loaded = any(one.loaded for one in flags)
        message.stale = any(one.stale for one in flags) or between is None
        message.extrapolating = any(one.extrapolating for one in flags)
        message.valid = all(one.valid for one in flags) and bool(message.measured[2])
        return message

    # Channels

    def _sideways_force(self, foot: int, readings: FloatArray) -> FloatArray:
        """(2,) force x, y [N] of a six-axis sensor; NaN where there is none."""
        force = np.full(2, np.nan)
        for axis, channel in self._sideways[foot]:
            force[axis] = self._law.gain[channel] * readings[channel] + self._law.offset[channel]
        return force


def no_forces(
    stamp_ns: int, calibration_id: str, soles: tuple[str, str], flags: Sequence[FootFlags]
) -> ShoeForces:
    """A sample without numbers, which is not valid.

    Args:
        stamp_ns: of the last readings, or now [ns].
        calibration_id: in force; empty while uncalibrated.
        soles: names of their frames.
        flags: of each foot.
    """
    unknown = np.full(6, np.nan)
    frames = (*soles, soles[LEFT])
    left, right, both = (_message(frame, unknown, None, NOTHING) for frame in frames)
    for one, own in zip((left, right), flags, strict=True):
        one.stale = own.stale
    both.stale = any(one.stale for one in flags)
    header = header_to_ros(stamp_ns, both.frame_id)
    return ShoeForces(header=header, calibration=calibration_id, left=left, right=right, both=both)


def _sideways(shoe: Shoe, foot: int) -> list[tuple[int, int]]:
    """Axis (0: x, 1: y) and channel of what measures sideways forces of a foot."""
    names = {f"{FEET[foot]}/fx": 0, f"{FEET[foot]}/fy": 1}
    return [
        (names[channel.name], index)
        for index, channel in enumerate(shoe.channels)
        # A cell may have any name; it adds to the vertical force.
        if channel.name in names and not channel.torque and not channel.vertical
    ]


def _spread(stated: StatedWrench) -> Spread:
    return stated.covariance, stated.output_covariance[1:, 1:]


def _message(
    frame: str, wrench: FloatArray, place: Sequence[float] | None, spread: Spread
) -> FootForce:
    force, torque = wrench[:3].tolist(), wrench[3:].tolist()
    x, y, z = (math.nan,) * 3 if place is None else place
    return FootForce(
        frame_id=frame,
        wrench=Wrench(
            force=Vector3(x=force[0], y=force[1], z=force[2]),
            torque=Vector3(x=torque[0], y=torque[1], z=torque[2]),
        ),
        measured=np.isfinite(wrench).tolist(),
        covariance=spread[0].ravel(),
        has_cop=place is not None,
        cop=Point(x=float(x), y=float(y), z=float(z)),
        cop_covariance=(NOTHING if place is None else spread)[1].ravel(),
    )

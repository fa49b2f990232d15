"""What a fit needs of a recording: readings and what the model says of the same instants.

A stance is a stretch of time in which no loaded foot moves, so that one frame and one set of
channel columns serve all of its samples. A run in double support is one stance, or several
where a foot is lifted; walking is many.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.errors import ShapeError, ShoecalError
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import at_cop, columns_in_left, combined, weight_below


@dataclass(frozen=True)
class Stance:
    """T samples of one stance.

    Vectors are in the stance's frame: the left sole's while the left foot is loaded, else the
    right sole's.

    Attributes:
        run: number of the run it was taken from.
        loaded: which feet carry the robot.
        support: where the right foot stands; for a single support where it hangs (unused).
        time: (T,) since the run's start [s].
        readings: (T, n) raw.
        force: (T,) vertical force that the model expects: the weight when quasi-static [N].
        cop: (T, 2) modelled CoP [m].
        cop_rate: (T, 2) its rate of change, for the time offset [m/s].
        columns: (n, 3) what one unit of each output adds to the total wrench.
        base: (3,) wrench of the parts below the channels of the loaded feet.
        angles: (T, m) joint angles behind the model's values [rad]; None where there is no body.
        push: (T, 2) sideways force of the floor that the model expects; None for slow motions [N].
    """

    run: int
    loaded: tuple[bool, bool]
    support: DoubleSupport
    time: FloatArray
    readings: FloatArray
    force: FloatArray
    cop: FloatArray
    cop_rate: FloatArray
    columns: FloatArray
    base: FloatArray
    angles: FloatArray | None = None
    push: FloatArray | None = None

    def __post_init__(self) -> None:
        count = len(self.time)
        channels = len(self.columns)
        for name, array, shape in (
            ("readings", self.readings, (count, channels)),
            ("force", self.force, (count,)),
            ("cop", self.cop, (count, 2)),
            ("cop_rate", self.cop_rate, (count, 2)),
            ("columns", self.columns, (channels, 3)),
            ("base", self.base, (3,)),
        ):
            if array.shape != shape:
                raise ShapeError(name, str(shape), array.shape)
            if not np.isfinite(array).all():
                raise ShoecalError(f"run {self.run}: {name} holds a number that is not finite")
        if self.angles is not None and self.angles.shape[:-1] != (count,):
            raise ShapeError("angles", f"({count}, m)", self.angles.shape)

    @property
    def duration(self) -> float:
        """Time that its samples stand for [s]."""
        count = len(self.time)
        if count < 2:
            return 0.0
        return float(np.median(np.diff(self.time))) * count

    @property
    def hanging(self) -> int | None:
        """Index of the foot that hangs in the air, if one does."""
        return None if all(self.loaded) else self.loaded.index(False)

    @property
    def quasi_static(self) -> bool:
        """Whether the model expects the weight alone, at the CoM's projection."""
        return bool(np.ptp(self.force) == 0.0) if len(self.force) else True

    @property
    def reference(self) -> FloatArray:
        """(T, 3) wrench F, Mx, My that the model expects [N, N m]."""
        return at_cop(self.force, self.cop)

    def part(self, part: slice | BoolArray) -> Stance:
        """Some of its samples: a slice, or those marked (T,)."""
        return replace(
            self,
            time=self.time[part],
            readings=self.readings[part],
            force=self.force[part],
            cop=self.cop[part],
            cop_rate=self.cop_rate[part],
            angles=None if self.angles is None else self.angles[part],
            push=None if self.push is None else self.push[part],
        )


def make_stance(
    run: int,
    shoe: Shoe,
    support: DoubleSupport,
    loaded: tuple[bool, bool],
    time: FloatArray,
    readings: FloatArray,
    force: FloatArray,
    cop: FloatArray,
    angles: FloatArray | None = None,
) -> Stance:
    """A stance of given samples; columns, base and rate of the CoP follow.

    Args:
        run, support, loaded: as `Stance`.
        shoe: that was worn.
        time: (T,) since the run's start [s].
        readings: (T, n) raw.
        force: (T,) modelled vertical force [N].
        cop: (T, 2) modelled CoP in the stance's frame [m].
        angles: (T, m) joint angles [rad], if there is a body.
    """
    if all(loaded):
        columns = columns_in_left(shoe, support)
        base = combined(weight_below(shoe), support)
    else:
        foot = loaded.index(True)
        columns = np.where((shoe.foot == foot)[:, None], shoe.columns, 0.0)
        base = weight_below(shoe)[foot]
    rate = np.gradient(cop, time, axis=0) if len(time) > 1 else np.zeros_like(cop)
    return Stance(
        run, loaded, support, time, readings, force, cop, rate, columns, np.asarray(base), angles,
    )  # fmt: skip

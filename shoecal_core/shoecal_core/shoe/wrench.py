"""Ground reaction force (GRF) and centre of pressure (CoP) from channel outputs.

The vertical floor wrench of a foot is w = (F, Mx, My): the floor's vertical force and its
moments about the origin of a frame on the floor. A force F at (x, y) is the wrench
(F, y F, -x F), so the CoP of a wrench is (-My, Mx) / F.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShapeError, ShoecalError
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.shoe.shoe import Shoe


@dataclass(frozen=True)
class ChannelParameters:
    """Affine law of every channel: output = gain * reading + offset (paper, eq. 3).

    Attributes:
        gain: (n,) [N or N m per unit of reading].
        offset: (n,) [N or N m].
    """

    gain: FloatArray
    offset: FloatArray

    def __post_init__(self) -> None:
        if self.gain.ndim != 1 or self.gain.shape != self.offset.shape:
            raise ShapeError("offset", f"as gain {self.gain.shape}", self.offset.shape)
        if not (np.isfinite(self.gain).all() and np.isfinite(self.offset).all()):
            raise ShoecalError("gains and offsets must be finite numbers")

    def outputs(self, readings: FloatArray) -> FloatArray:
        """Outputs (..., n) [N or N m] of readings (..., n)."""
        if readings.shape[-1] != len(self.gain):
            raise ShapeError("readings", f"(..., {len(self.gain)})", readings.shape)
        return self.gain * readings + self.offset

    def readings(self, outputs: FloatArray) -> FloatArray:
        """Readings (..., n) of outputs (..., n) [N or N m]."""
        found: FloatArray = (outputs - self.offset) / self.gain
        return found


def weight_below(shoe: Shoe) -> FloatArray:
    """(2, 3) wrench of each foot's parts below the channels, in its sole frame [N, N m].

    The floor carries them too, but no channel feels them; with them a hanging foot, whose
    channels are pulled by that weight, reads zero.
    """
    wrenches = []
    for plates in shoe.plates:
        force = plates.mass_below * GRAVITY
        x, y, _ = plates.com_below
        wrenches.append((force, y * force, -x * force))
    return np.array(wrenches)


def foot_wrenches(shoe: Shoe, outputs: FloatArray) -> FloatArray:
    """Floor wrench (..., 2, 3) of each foot in its sole frame (paper, eq. 1, and moments).

    Args:
        outputs: (..., n) of the channels [N or N m].
    """
    each = [outputs[..., shoe.of_foot(foot)] @ shoe.columns[shoe.of_foot(foot)] for foot in (0, 1)]
    return np.stack(each, axis=-2) + weight_below(shoe)


def cop(wrench: FloatArray, minimum_force: float) -> FloatArray:
    """CoP (..., 2) of wrenches (..., 3) (paper, eq. 2), NaN where the force is too small.

    Args:
        minimum_force: below it there is no CoP [N].
    """
    force = wrench[..., 0]
    loaded = force > minimum_force
    divisor = np.where(loaded, force, np.nan)
    return np.stack((-wrench[..., 2] / divisor, wrench[..., 1] / divisor), axis=-1)


def cop_jacobian(wrench: FloatArray) -> FloatArray:
    """(..., 3, 3) of force [N] and CoP x, y [m] to the wrench's F, Mx, My (paper, eq. 2).

    Args:
        wrench: (..., 3) at which to differentiate [N, N m]; its force must not be zero.
    """
    force = wrench[..., 0]
    found = np.zeros((*wrench.shape, 3))
    found[..., 0, 0] = 1.0
    found[..., 1, 0] = wrench[..., 2] / force**2
    found[..., 1, 2] = -1.0 / force
    found[..., 2, 0] = -wrench[..., 1] / force**2
    found[..., 2, 1] = 1.0 / force
    return found


def by_parameters(slopes: FloatArray, readings: FloatArray) -> FloatArray:
    """(..., k, 2n) by gains, then offsets, of what depends on outputs by slopes (..., k, n).

    Args:
        readings: (..., n) that the gains multiply.
    """
    gains = slopes * readings[..., None, :]
    return np.concatenate((gains, np.broadcast_to(slopes, gains.shape)), axis=-1)


def at_cop(force: FloatArray, place: FloatArray) -> FloatArray:
    """Wrench (..., 3) [N, N m] of a vertical force (...,) [N] at a place (..., 2) [m]."""
    return np.stack((force, place[..., 1] * force, -place[..., 0] * force), axis=-1)


def to_left(support: DoubleSupport) -> FloatArray:
    """(3, 3) maps a wrench in the right sole's frame to the left's: w_left = T w_right."""
    matrix = np.zeros((3, 3))
    matrix[0, 0] = 1.0
    matrix[1:, 0] = support.dy, -support.dx
    matrix[1:, 1:] = support.rotation
    return matrix


def columns_in_left(shoe: Shoe, support: DoubleSupport) -> FloatArray:
    """(n, 3) channel columns of both feet in the left sole's frame."""
    columns = shoe.columns.copy()
    right = shoe.of_foot(1)
    columns[right] = columns[right] @ to_left(support).T
    return columns


def combined(wrenches: FloatArray, support: DoubleSupport) -> FloatArray:
    """Wrench (..., 3) of both feet together in the left sole's frame [N, N m].

    Args:
        wrenches: (..., 2, 3) of each foot in its own sole frame [N, N m].
    """
    both: FloatArray = wrenches[..., 0, :] + wrenches[..., 1, :] @ to_left(support).T
    return both

"""When to be where on a path: as fast as the limits allow, from rest to rest.

Along a path q(s) with x = (ds/dt)^2, speed and acceleration of anything that depends on s are

    |dr/dt|^2 = |r'|^2 x          d2r/dt2 = r'' x + r' x' / 2

linear in x and its derivative. So the fastest profile x(s) is a linear program.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.interpolate import CubicSpline
from scipy.optimize import linprog

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShoecalError

GRID = 5
"""Points of the profile a state."""
_DIRECTIONS = 8
"""A circle of allowed CoM accelerations is taken as a polygon of twice as many sides."""


class TimingError(ShoecalError):
    """A path that no profile of speed fits."""


@dataclass(frozen=True)
class Rates:
    """Limits of how fast a path is followed.

    Attributes:
        joint_speed: (k,) [rad/s].
        joint_acceleration: (k,) [rad/s^2].
        com_speed: [m/s].
        com_acceleration: [m/s^2].
        state_rate: states a second at most.
    """

    joint_speed: FloatArray
    joint_acceleration: FloatArray
    com_speed: float
    com_acceleration: float
    state_rate: float


@dataclass(frozen=True)
class Profile:
    """How far along the path one is at what time.

    Attributes:
        s: (n,) grid on the path.
        rate: (n,) ds/dt there, zero at both ends [1/s].
    """

    s: FloatArray
    rate: FloatArray

    @property
    def times(self) -> FloatArray:
        """(n,) time at each grid point; between two of them d2s/dt2 is constant [s]."""
        steps = 2.0 * np.diff(self.s) / (self.rate[1:] + self.rate[:-1])
        return np.concatenate([[0.0], np.cumsum(steps)])

    def at(self, time: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Place s and ds/dt at times (T,) from zero to the end [s]; clamped beyond."""
        times = self.times
        arrived = time >= times[-1]
        time = np.clip(time, 0.0, times[-1])
        index = np.clip(np.searchsorted(times, time, side="right") - 1, 0, len(times) - 2)
        since = time - times[index]
        change = np.diff(self.rate) / np.diff(times)
        rate = self.rate[index] + change[index] * since
        s = self.s[index] + (self.rate[index] + rate) / 2.0 * since
        # At rest is at rest, whatever rounding says.
        return np.where(arrived, self.s[-1], s), np.where(arrived, self.rate[-1], rate)


def fastest(path: CubicSpline, com: FloatArray, s: FloatArray, rates: Rates) -> Profile:
    """The fastest profile along a path of joint angles.

    Args:
        path: leg angles (k,) as a function of s [rad].
        com: (n, 2) ground projection of the CoM at `s` [m].
        s: (n,) evenly spaced grid.
        rates: the limits.

    Raises:
        TimingError: when there is none.
    """
    ground = CubicSpline(s, com)
    first, second = path(s, 1), path(s, 2)
    com_first, com_second = ground(s, 1), ground(s, 2)
    tiny = 1e-12
    fastest_rate = np.minimum.reduce(
        [
            np.min(rates.joint_speed / (np.abs(first) + tiny), axis=1),
            rates.com_speed / (np.linalg.norm(com_first, axis=1) + tiny),
            np.full(len(s), rates.state_rate),
        ]
    )
    upper = fastest_rate**2
    upper[[0, -1]] = 0.0
    angles = np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    directions = np.stack([np.cos(angles), np.sin(angles)])
    # Inside the polygon whose sides touch a circle smaller by this much, one is in the circle.
    inner = rates.com_acceleration * np.cos(np.pi / (2 * _DIRECTIONS))
    slopes = np.hstack([first, com_first @ directions]).T
    bends = np.hstack([second, com_second @ directions]).T
    bounds = np.concatenate([rates.joint_acceleration, np.full(_DIRECTIONS, inner)])
    matrix = _accelerations(slopes / bounds[:, None], bends / bounds[:, None], s[1] - s[0])
    scale = float(upper.max())
    result = linprog(  # type: ignore[call-overload]  # its stubs know no sparse matrix
        -np.ones(len(s)),
        A_ub=sp.vstack([matrix, -matrix]) * scale,
        b_ub=np.ones(2 * matrix.shape[0]),
        bounds=np.column_stack([np.zeros(len(s)), upper / scale]),
        method="highs",
    )
    if result.x is None or not np.all(result.x[1:-1] > 0.0):
        raise TimingError(
            f"no speed keeps joint_acceleration and dynamic_cop_error along the path "
            f"({result.message}); raise them"
        )
    return Profile(s, np.sqrt(scale * np.clip(result.x, 0.0, None)))


def _accelerations(slopes: FloatArray, bends: FloatArray, step: float) -> sp.csr_matrix:
    """Rows r'' x + r' x' / 2 at both ends of every interval.

    Args:
        slopes, bends: (r, n) first and second derivatives by s.
        step: of the grid.
    """
    count = slopes.shape[1]
    change = slopes / (2.0 * step)
    blocks = []
    for slope, bend in zip(change, bends, strict=True):
        begin = [bend[:-1] - slope[:-1], slope[:-1]]
        end = [-slope[1:], bend[1:] + slope[1:]]
        blocks += [sp.diags(rows, [0, 1], shape=(count - 1, count)) for rows in (begin, end)]
    return sp.vstack(blocks).tocsr()

"""Does a foot carry load where the planned CoP says that it has to?"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.shoe.shoe import FEET

DIRECTIONS = 72
"""In which the feet's outlines are compared: every 5 degrees."""
UNEVEN = 0.2
"""Part of the weight by which a foot may carry less than the lever rule gives it."""


def least_shares(cop: FloatArray, own: FloatArray, other: FloatArray) -> FloatArray:
    """(T,) least part of the weight that a foot carries, 0 to 1.

    The CoP is (1 - s) p + s q with q under this foot and p under the other one. So for every
    direction u, u c <= (1 - s) max u p + s max u q; the greatest lower bound of s counts.

    Args:
        cop: (T, 2) of the whole robot [m].
        own: (k, 2) corners of this foot's outline, same frame [m].
        other: (l, 2) corners of the other foot's.
    """
    angles = np.linspace(0.0, 2.0 * np.pi, DIRECTIONS, endpoint=False)
    directions = np.stack([np.cos(angles), np.sin(angles)])
    reach, others = (own @ directions).max(axis=0), (other @ directions).max(axis=0)
    way = reach - others
    ahead = way > 1e-6
    shares = (cop @ directions[:, ahead] - others[ahead]) / way[ahead]
    least: FloatArray = np.clip(shares.max(axis=1, initial=0.0), 0.0, 1.0)
    return least


def needed_shares(cop: FloatArray, own: FloatArray, other: FloatArray) -> FloatArray:
    """(T,) part of the weight below which a foot does not carry as it should, 0 to 1.

    The least one by statics; or, where that is more, what the lever rule between the middles of
    both feet gives, less what legs and floor may change of it.

    Args:
        cop, own, other: as for `least_shares`.
    """
    middle = other.mean(axis=0)
    way = own.mean(axis=0) - middle
    lever = np.clip((cop - middle) @ way / (way @ way), 0.0, 1.0)
    needed: FloatArray = np.maximum(least_shares(cop, own, other), lever - UNEVEN)
    return needed


class LoadWatch:
    """Shows which foot has carried nothing for too long although it had to carry."""

    def __init__(
        self, time: FloatArray, needed: FloatArray, least: float, late_s: float, patience_s: float
    ) -> None:
        """A motion begins.

        Args:
            time: (T,) of the motion [s].
            needed: (T, 2) load that each foot has at least, left and right [N].
            least: a foot that needs less may carry nothing [N].
            late_s: how late the robot may be [s].
            patience_s: for how long a foot may carry nothing [s].
        """
        self._time = time
        self._has_to = needed > least
        self._needed = needed
        self._late_s = late_s
        self._patience_s = patience_s
        self._since: list[float | None] = [None, None]

    def look(self, elapsed: float, loaded: Sequence[bool | None]) -> str:
        """Take what both feet report at a time of the motion; what is wrong, empty when nothing.

        Args:
            elapsed: since the motion was sent [s].
            loaded: left, right; None where unknown.
        """
        first, last = np.searchsorted(self._time, [elapsed - self._late_s, elapsed])
        span = slice(min(int(first), len(self._time) - 1), int(last) + 1)
        for foot, name in enumerate(FEET):
            if loaded[foot] is not False or not self._has_to[span, foot].all():
                self._since[foot] = None
                continue
            since = self._since[foot]
            if since is None:
                self._since[foot] = since = elapsed
            if elapsed - since >= self._patience_s:
                least = float(self._needed[span, foot].min())
                return (
                    f"the {name} foot carries nothing, where the planned CoP puts at least "
                    f"{least:.0f} N on it"
                )
        return ""

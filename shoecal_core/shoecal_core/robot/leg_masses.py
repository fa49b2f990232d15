"""Links of both legs that should have the same mass and do not."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import pinocchio as pin

UNLIKE = 1.9
"""Times the mass of its counterpart in the other leg from which a link is looked at: doubled, or
half of it, both rounded."""
NOTABLE = 0.02
"""Share of the robot's mass from which such a difference matters."""


def unlike_masses(
    model: pin.Model, pairs: Iterable[tuple[int, int]], total: float
) -> Iterator[tuple[int, int, tuple[float, float]]]:
    """Joints of the left and the right leg whose links' masses [kg] are unlike, with these.

    Args:
        model: of the robot.
        pairs: joints of the model that are each other's counterparts.
        total: mass of the robot [kg].
    """
    for left, right in pairs:
        masses = (float(model.inertias[left].mass), float(model.inertias[right].mass))
        if max(masses) > UNLIKE * min(masses) and max(masses) - min(masses) > NOTABLE * total:
            yield left, right, masses

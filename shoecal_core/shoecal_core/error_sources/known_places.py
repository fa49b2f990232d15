"""Where effects can sit in a robot and its shoes, before anything was recorded."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import cast

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.base import Effect, Place
from shoecal_core.error_sources.body import heavy_links
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import Shoe


@dataclass(frozen=True)
class _HeavyLinks:
    names: tuple[str, ...]
    mass: FloatArray


@dataclass(frozen=True)
class _Unrecorded:
    """What places of effects are made from, of a signal model: its robot, shoes and links."""

    robot: Robot
    shoe: Shoe

    @property
    def samples(self) -> _Unrecorded:
        """Itself: samples know robot and shoes."""
        return self

    @cached_property
    def links(self) -> _HeavyLinks:
        """Links with a mass [kg]."""
        carried = heavy_links(self.robot)
        return _HeavyLinks(
            tuple(str(frame.name) for _, frame in carried),
            np.array([self.robot.model.inertias[joint].mass for joint, _ in carried]),
        )


def known_places(effect: Effect, robot: Robot, shoe: Shoe) -> Iterator[Place]:
    """Where an effect of the library can sit; one of a user's own may need a recording."""
    yield from effect.places(cast(SignalModel, _Unrecorded(robot, shoe)))

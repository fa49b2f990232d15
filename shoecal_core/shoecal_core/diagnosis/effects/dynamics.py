"""Effects of motion: what quasi-static models leave out."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from shoecal_core.diagnosis.effects.base import Component, Place, Shape
from shoecal_core.diagnosis.signals import Scene
from shoecal_core.model.robot import GRAVITY


class Inertia:
    """The CoP is the zero-moment point, which accelerations move off the CoM's projection."""

    identifier, group = "inertia", "dynamics"
    components = (Component("factor", "", 1.0),)

    def places(self, scene: Scene) -> Iterator[Place]:
        """The whole body."""
        yield ()

    def shapes(self, scene: Scene, place: Place) -> Iterator[Shape]:
        """Of a mass at the CoM: -h a / g."""
        samples = scene.samples
        height = samples.states.com[np.arange(len(samples.run)), samples.frame, 2]
        cop = -(height / GRAVITY)[:, None] * samples.acceleration
        yield Shape(("factor",), scene.by_model(0.0, cop)[None])

"""Effects of motion: what quasi-static models leave out."""

from __future__ import annotations

from collections.abc import Iterator

from shoecal_core.error_sources.base import Component, Place, Shape
from shoecal_core.error_sources.scene import Scene


class Inertia:
    """The CoP is the zero-moment point, which accelerations move off the CoM's projection."""

    identifier, group = "inertia", "dynamics"
    components = (Component("factor", "", 1.0, 0.0),)

    def places(self, scene: Scene) -> Iterator[Place]:
        """The whole body."""
        yield ()

    def shapes(self, scene: Scene, place: Place) -> Iterator[Shape]:
        """Of the whole body: -h a / g of its CoM, and what its angular momentum adds."""
        # In slow motions it is taken for granted, whatever else is looked for.
        if scene.fast:
            yield Shape(("factor",), scene.dynamic[None])

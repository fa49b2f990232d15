"""Effects of motion: what quasi-static models leave out."""

from __future__ import annotations

from collections.abc import Iterator

from shoecal_core.error_sources.base import Component, Place, Shape
from shoecal_core.error_sources.signal_model import SignalModel


class Inertia:
    """The CoP is the zero-moment point, which accelerations move off the CoM's projection."""

    identifier, group = "inertia", "dynamics"
    components = (Component("factor", "", 1.0, 0.0),)

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """The whole body."""
        yield ()

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """Of the whole body: -h a / g of its CoM, and what its angular momentum adds."""
        # In slow motions it is taken for granted, whatever else is looked for.
        if signal_model.fast:
            yield Shape(("factor",), signal_model.dynamic[None])

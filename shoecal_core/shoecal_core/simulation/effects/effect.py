"""What an effect of the real world can change."""

from __future__ import annotations

from shoecal_core.simulation.drawn import DrawnBody, DrawnShoes


class Effect:
    """One effect of the real world; without more it changes nothing.

    Identifiers, locations and sizes are those that a diagnosis reports; what they do here is the
    physics, or a law of another form than a diagnosis would fit.
    """

    def on_body(self, body: DrawnBody) -> DrawnBody:
        """The robot with this effect."""
        return body

    def on_shoes(self, shoes: DrawnShoes) -> DrawnShoes:
        """The shoes, and the floor below them, with this effect."""
        return shoes

"""Effects of motion itself."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from shoecal_core.files import Fields
from shoecal_core.simulation.effects.effect import Effect


@dataclass(frozen=True)
class Inertia(Effect):
    """The CoP is the zero-moment point: the physics always has it, so there is nothing to add."""

    @classmethod
    def read(cls, fields: Fields) -> Inertia:
        """From the item of a reality file; its factor can be nothing but 1."""
        fields.only("effect", "location", "factor")
        fields.number("factor", 1.0, minimum=1.0, maximum=1.0)
        return cls()


EFFECTS: dict[str, Callable[[Fields], Effect]] = {"inertia": Inertia.read}
"""Effects of this family by identifier."""

"""All effects by identifier."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from shoecal_core.files import Fields
from shoecal_core.simulation.effects import (
    body,
    contact,
    curve,
    drift,
    memory,
    mounting,
    slip,
    timing,
    wiring,
    zero,
)
from shoecal_core.simulation.effects.effect import Effect

EFFECTS: Mapping[str, Callable[[Fields], Effect]] = {
    **curve.EFFECTS,
    **memory.EFFECTS,
    **zero.EFFECTS,
    **drift.EFFECTS,
    **wiring.EFFECTS,
    **mounting.EFFECTS,
    **timing.EFFECTS,
    **body.EFFECTS,
    **contact.EFFECTS,
    **slip.EFFECTS,
}
"""How the item of each is read."""


def read_effect(fields: Fields) -> Effect:
    """One item of a reality file's list of effects.

    Raises:
        FileError: for an unknown effect or a size that is missing or mistyped.
    """
    return EFFECTS[fields.choice("effect", EFFECTS)](fields)

"""Where an effect sits: the names that its item of a reality file lists."""

from __future__ import annotations

from shoecal_core.files import Fields
from shoecal_core.sensing.shoe import FEET
from shoecal_core.simulation.reality import ALL


def read_feet(fields: Fields) -> tuple[str, ...]:
    """The feet that `location` lists; `all` means both.

    Raises:
        FileError: when it lists anything else.
    """
    names = fields.texts("location")
    if names == [ALL]:
        return FEET
    for name in names:
        if name not in FEET:
            raise fields.error("location", f"'{name}' is not one of: {', '.join(FEET)}, {ALL}")
    return tuple(names)

"""All effects that a diagnosis knows, and those of a user's own file."""

from __future__ import annotations

import importlib.util
from pathlib import Path

from shoecal_core.error_sources.base import Effect
from shoecal_core.error_sources.effects import (
    body,
    contact,
    geometry,
    load_cell,
    timing,
)
from shoecal_core.errors import FieldError, FileSyntaxError
from shoecal_core.files import open_file

EFFECTS: tuple[Effect, ...] = (
    load_cell.Nonlinearity(),
    load_cell.Saturation(),
    load_cell.Hysteresis(),
    load_cell.Creep(),
    load_cell.ZeroOffset(),
    load_cell.ZeroDrift(),
    load_cell.SpanDrift(),
    load_cell.StuckCell(),
    geometry.SwappedCells(),
    geometry.Crosstalk(),
    geometry.CellPosition(),
    geometry.OffAxisLoad(),
    timing.Latency(),
    timing.LowPass(),
    body.TotalMass(),
    body.Payload(),
    body.LinkCom(),
    body.JointOffset(),
    body.JointCompliance(),
    body.Backlash(),
    contact.FootPlacement(),
    contact.Slip(),
    contact.FloorTilt(),
    contact.SoftGround(),
    body.Inertia(),
)
"""In the order of the documentation."""
MEMBERS = ("identifier", "group", "components", "places", "shapes")
"""What makes an effect."""


def effects_from(path: Path) -> tuple[Effect, ...]:
    """Effects of a user's own: `EFFECTS` of a Python file.

    Raises:
        FileMissingError, FileUnreadableError: when it cannot be read.
        FileSyntaxError: when it cannot be run.
        FieldError: when it defines none, or something else.
    """
    open_file(path).close()
    spec = importlib.util.spec_from_file_location(path.stem, path)
    if spec is None or spec.loader is None:
        raise FileSyntaxError(path, "is no Python file with effects")
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise FileSyntaxError(path, f"cannot be run: {type(error).__name__}: {error}") from error
    effects = getattr(module, "EFFECTS", None)
    if not isinstance(effects, (tuple, list)) or not effects:
        raise FieldError(path, "defines no EFFECTS = (MyEffect(), ...)")
    for effect in effects:
        if lacking := [name for name in MEMBERS if not hasattr(effect, name)]:
            raise FieldError(
                path,
                f"{effect!r} in EFFECTS is no effect: it lacks {', '.join(lacking)}; "
                "see shoecal_core.error_sources.base.Effect",
            )
    return tuple(effects)

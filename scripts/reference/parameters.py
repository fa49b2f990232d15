"""Parameters of all nodes, and the settings of `shoecal diagnose`."""

from __future__ import annotations

import math
from collections.abc import Sequence

from reference.made import Made
from reference.markdown import code, page, table
from shoecal_core.settings import Setting, Settings, describe

_LEAD = (
    "Every parameter is read when its node starts, checked, and read-only from then on. A name "
    "that a node does not have, a type or a value out of bounds ends it with one line. The files "
    "`config/nodes/NODE.yaml` hold them all with their defaults."
)


def parameters_page(made: Sequence[Made]) -> str:
    """The page."""
    parts = []
    for node in made:
        parts += [f"## {node.node}", node.doc]
        parts += [_table(section, cls) for section, cls in node.settings]
    return page("Parameters", _LEAD, parts)


def _table(section: str, cls: type[Settings]) -> str:
    rows = (
        (
            code(f"{section}{entry.name}"),
            code(_value(entry.default)),
            entry.unit,
            _bounds(entry),
            entry.doc,
        )
        for entry in describe(cls)
    )
    return table(("parameter", "default", "unit", "allowed", "what it is"), rows)


def _value(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f"{value:g}"
    return f"'{value}'" if isinstance(value, str) else str(value)


def _bounds(entry: Setting) -> str:
    if entry.choices:
        return ", ".join(map(code, entry.choices))
    if entry.kind is bool:
        return "`true`, `false`"
    low = f"{entry.minimum:g}" if entry.minimum > -math.inf else ""
    high = f"{entry.maximum:g}" if entry.maximum < math.inf else ""
    if low and high:
        return f"{low} to {high}"
    return f"at least {low}" if low else f"at most {high}" if high else ""

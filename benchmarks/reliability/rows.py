"""All rows: those that the modules of this package declare."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from dataclasses import dataclass

import reliability
from reliability.row import Row


@dataclass(frozen=True)
class Found:
    """A row, the name of its module, and the first paragraph of that module's docstring."""

    row: Row
    module: str
    about: str


def find_rows() -> dict[str, Found]:
    """Every row by its key, in the order of the modules' names.

    Raises:
        ValueError: when two rows have one key.
    """
    rows: dict[str, Found] = {}
    for info in pkgutil.iter_modules(reliability.__path__):
        for key, found in rows_of(info.name).items():
            if key in rows:
                raise ValueError(f"two rows have the key {key}; rename one")
            rows[key] = found
    return rows


def rows_of(name: str) -> dict[str, Found]:
    """The rows of one module, by key."""
    module = importlib.import_module(f"{reliability.__name__}.{name}")
    declared: tuple[Row, ...] = getattr(module, "ROWS", ())
    if row := getattr(module, "ROW", None):
        declared = (*declared, row)
    about = (inspect.getdoc(module) or "").partition("\n\n")[0]
    return {row.key: Found(row, name, about) for row in declared}

"""All rows: the modules of this package that have one."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from dataclasses import dataclass

import reliability
from reliability.row import Row


@dataclass(frozen=True)
class Found:
    """A row and its module's docstring, which explains it."""

    row: Row
    about: str


def find_rows() -> dict[str, Found]:
    """Every row by its key, in the order of the modules' names.

    Raises:
        ValueError: when two modules give their rows one key.
    """
    rows: dict[str, Found] = {}
    for info in pkgutil.iter_modules(reliability.__path__):
        module = importlib.import_module(f"{reliability.__name__}.{info.name}")
        row = getattr(module, "ROW", None)
        if isinstance(row, Row):
            if row.key in rows:
                raise ValueError(f"two rows have the key {row.key}; rename one")
            rows[row.key] = Found(row, inspect.getdoc(module) or "")
    return rows

"""All rows: the modules of this package that have one."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from dataclasses import dataclass

import reliability
from reliability.row import Row
from reliability.sources import digest


@dataclass(frozen=True)
class Found:
    """A row, its module's docstring, which explains it, and the module's name."""

    row: Row
    about: str
    module: str

    @property
    def code(self) -> str:
        """Digest of the sources that the row would run with now."""
        return digest(self.module)


def find_rows() -> dict[str, Found]:
    """Every row by its key, in the order of the modules' names.

    Raises:
        ValueError: when two modules give their rows one key.
    """
    rows: dict[str, Found] = {}
    for info in pkgutil.iter_modules(reliability.__path__):
        found = find_row(info.name)
        if found is not None:
            if found.row.key in rows:
                raise ValueError(f"two rows have the key {found.row.key}; rename one")
            rows[found.row.key] = found
    return rows


def find_row(name: str) -> Found | None:
    """The row of one module, None where it has none."""
    module = importlib.import_module(f"{reliability.__name__}.{name}")
    row = getattr(module, "ROW", None)
    return Found(row, inspect.getdoc(module) or "", name) if isinstance(row, Row) else None

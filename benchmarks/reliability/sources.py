"""Which code was tried: a digest of the sources that a row's tries can reach.

Those are the row's module and all that it imports, directly or not, of the suite, of the tests'
helpers and of this package, and the programs beside them that they start. What starts or loads
modules by their names may reach anything: it brings the whole suite.
"""

from __future__ import annotations

import ast
import hashlib
import re
from collections.abc import Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from pages import ROOT

SUITE = ("shoecal_core", "shoecal_ros")
PACKAGES = (*SUITE, "ros", "reliability")
"""Packages whose imports are followed; `ros` is that of the tests, which starts nodes."""

_BY_NAME = re.compile(r'importlib\.import_module|"-m"')
_BESIDE = re.compile(r'with_name\("(\w+\.py)"\)')


def digest(module: str) -> str:
    """SHA-256 of the sources that a module of this package can reach."""
    folders = {name: _folder(name) for name in PACKAGES}
    whole = hashlib.sha256()
    for path in sorted(used(f"reliability.{module}")):
        name = next(name for name, folder in folders.items() if path.is_relative_to(folder))
        content = hashlib.sha256(path.read_bytes()).hexdigest()
        whole.update(f"{name}/{path.relative_to(folders[name])} {content}\n".encode())
    return whole.hexdigest()


def used(module: str) -> set[Path]:
    """Files of a module, by its full name, and of all that it can reach."""
    found: set[Path] = set()
    waiting = {file for file in (_file(module),) if file}
    while waiting:
        path = waiting.pop()
        if path not in found:
            found.add(path)
            waiting |= _reached(path)
    return found


@cache
def _reached(path: Path) -> frozenset[Path]:
    """What a file imports or starts."""
    text = path.read_text()
    names = set(_imported(ast.parse(text)))
    if _BY_NAME.search(text):
        names |= _suite()
    inside = {name for name in names if name.partition(".")[0] in PACKAGES}
    # Whoever imports a module runs the packages around it; some names are of things inside one.
    files = (_file(around) for name in inside for around in _lineage(name))
    programs = (path.with_name(program) for program in _BESIDE.findall(text))
    return frozenset(file for file in (*files, *programs) if file)


def _imported(tree: ast.Module) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield from (f"{node.module}.{name.name}" for name in node.names)


def _lineage(name: str) -> Iterator[str]:
    """`a.b.c`, `a.b` and `a`."""
    while name:
        yield name
        name = name.rpartition(".")[0]


def _file(name: str) -> Path | None:
    """Of a module or a package; None for what is neither."""
    package, *inner = name.split(".")
    path = _folder(package).joinpath(*inner)
    files = (path / "__init__.py", path.with_suffix(".py"))
    return next((file for file in files if file.is_file()), None)


@cache
def _suite() -> frozenset[str]:
    """Full names of all modules of the suite."""
    names = set()
    for package in SUITE:
        folder = _folder(package)
        for path in folder.rglob("*.py"):
            names.add(".".join((package, *path.relative_to(folder).with_suffix("").parts)))
    return frozenset(name.removesuffix(".__init__") for name in names)


@cache
def _folder(package: str) -> Path:
    if package == "ros":  # has no __init__, and not every row has it on its path
        return ROOT / "test" / "ros"
    spec = find_spec(package)
    assert spec is not None
    assert spec.submodule_search_locations is not None
    return Path(next(iter(spec.submodule_search_locations)))

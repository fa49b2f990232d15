"""Which code was tried: a digest of the sources of the suite and of what tries them."""

from __future__ import annotations

import ast
import hashlib
from functools import cache
from pathlib import Path

import shoecal_core
import shoecal_ros

HERE = Path(__file__).parent
SUITE = tuple(Path(package.__path__[0]) for package in (shoecal_core, shoecal_ros))


def digest(module: str) -> str:
    """SHA-256 of the sources that a row's module runs with: the suite's, its own, its helpers'."""
    own = {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in used(module)}
    return hashlib.sha256(repr((_suite(), sorted(own.items()))).encode()).hexdigest()


@cache
def _suite() -> str:
    whole = hashlib.sha256()
    for folder in SUITE:
        for path in sorted(folder.rglob("*.py")):
            content = hashlib.sha256(path.read_bytes()).hexdigest()
            whole.update(f"{folder.name}/{path.relative_to(folder)} {content}\n".encode())
    return whole.hexdigest()


def used(module: str) -> set[Path]:
    """A module of this package, and those that it imports from it, directly or not."""
    found: set[Path] = set()
    waiting = {module}
    while waiting:
        path = HERE / f"{waiting.pop()}.py"
        if not path.is_file() or path in found:
            continue
        found.add(path)
        for node in ast.walk(ast.parse(path.read_bytes())):
            if not isinstance(node, ast.ImportFrom) or node.module is None:
                continue
            package, _, inner = node.module.partition(".")
            if package == HERE.name:
                waiting |= {inner} if inner else {name.name for name in node.names}
    return found

"""Which code was tried: a digest of the sources that a row's tries can reach.

Those are the row's module and all that it imports, directly or not, of the suite, of the tests'
helpers and of this package; the nodes and programs that it starts, with all that those import; the
files of config/ where one of them looks for it, the messages where one speaks them, and files of
data that one of them names.
"""

from __future__ import annotations

import ast
import hashlib
import re
from collections.abc import Iterable, Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from pages import ROOT

SUITE = ("shoecal_core", "shoecal_ros")
HELPERS = ("ros", "reliability")
"""Packages of the tests and of this one, which start nodes by their names."""
PACKAGES = (*SUITE, *HELPERS)
"""Packages whose imports are followed."""
NODES = "shoecal_ros.nodes"

_MESSAGES = "shoecal_msgs"
_INTERFACES = ("msg", "srv", "action")
_TESTS = ROOT / "test"
_BASES = (ROOT, _TESTS, _TESTS / "ros")
"""Folders from which files of data are named, besides that of whoever names them."""
_FILE = re.compile(r"\w[\w./-]{0,99}\.[a-z]\w*")
"""Name of a file, below some folder."""
_WORLD = "world.py"
"""Starts whatever node it is told to: those who tell it name the node."""


def digest(module: str) -> str:
    """SHA-256 of the sources that a module of this package can reach."""
    whole = hashlib.sha256()
    for path in sorted(used(f"reliability.{module}")):
        content = hashlib.sha256(path.read_bytes()).hexdigest()
        whole.update(f"{_place(path)} {content}\n".encode())
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
    """What a file imports, starts or reads."""
    if path.suffix != ".py":
        return frozenset(_data(_FILE.findall(path.read_text(errors="replace")), path))
    tree = ast.parse(path.read_text())
    names = {*_imported(tree), *_started(tree, path)}
    inside = {name for name in names if name.partition(".")[0] in PACKAGES}
    # Whoever imports a module runs the packages around it; some names are of things inside one.
    files = {_file(around) for name in inside for around in _lineage(name)}
    texts = {text for node in ast.walk(tree) if (text := _text(node))}
    files |= {path.parent / text for text in texts if text.endswith(".py")}
    files |= set(_data(filter(_FILE.fullmatch, texts), path))
    if any(name.startswith(f"{_MESSAGES}.") for name in names):
        files |= {file for kind in _INTERFACES for file in (ROOT / _MESSAGES / kind).iterdir()}
    if any(text.partition("/")[0] == "config" for text in texts):
        files |= set((ROOT / "config").rglob("*.*"))
    return frozenset(file for file in files if file and file.is_file())


def _imported(tree: ast.Module) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield from (f"{node.module}.{name.name}" for name in node.names)


def _started(tree: ast.Module, path: Path) -> Iterator[str]:
    """Modules that stand as texts: in commands of processes, and for who loads them by name."""
    within = any(path.is_relative_to(_folder(package)) for package in SUITE)
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr) and path.name != _WORLD:
            beginning = next(map(_text, node.values), "")
            yield from (name for name in _suite() if _begins(name, beginning))
        elif text := _text(node):
            yield from _suite().intersection((text,) if within else (text, f"{NODES}.{text}"))


def _begins(name: str, beginning: str) -> bool:
    """Whether a module's name begins with that of a package."""
    return beginning.count(".") > 1 and beginning.endswith(".") and name.startswith(beginning)


def _data(names: Iterable[str], path: Path) -> Iterator[Path]:
    """Files of data that a file names, beside it or below one of the bases."""
    for name in names:
        for base in (path.parent, *_BASES):
            file = base / name
            # Pages and results shape nothing, and change with every run.
            if file.suffix != ".py" and file.is_file() and _place(file):
                yield file


def _place(path: Path) -> str:
    """Of a file that a row can reach, wherever this copy of the project is; empty for others."""
    folders = {name: _folder(name) for name in PACKAGES}
    folders |= {name: ROOT / name for name in ("config", _MESSAGES, "test")}
    for name, folder in folders.items():
        if path.is_relative_to(folder):
            return f"{name}/{path.relative_to(folder)}"
    return ""


def _text(node: ast.AST) -> str:
    """That of a literal; empty for everything else."""
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else ""


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

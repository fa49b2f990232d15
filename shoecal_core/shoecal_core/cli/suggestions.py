"""What somebody may have meant who mistyped a name."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from difflib import get_close_matches
from pathlib import Path

from shoecal_core.workspace import config_dir

FOLDERS = ("robots", "shoes", "realities")
"""Of the configuration, whose files can be meant by their names alone."""


def nearest(given: str, known: Iterable[str]) -> str:
    """`; did you mean 'name'?`, empty where nothing looks like it."""
    found = get_close_matches(given, sorted(set(known)), n=1)
    return f"; did you mean '{found[0]}'?" if found else ""


def nearest_file(path: Path, named: Collection[Path] = ()) -> str:
    """The same of a file or folder that is not there.

    Looked for are its neighbours, and files of the configuration of that name.

    Args:
        path: of it.
        named: together with it: none of these was meant.
    """
    if path.exists():
        return ""
    missing = path
    while not missing.parent.is_dir():
        if missing.parent == missing:
            return ""
        missing = missing.parent
    rest = path.relative_to(missing)
    neighbours = {
        one.name: one for one in _entries(missing.parent) if not _is_among(one / rest, named)
    }
    found = get_close_matches(missing.name, sorted(neighbours), n=1)
    # Names that have no more in common than what they end with are none.
    if found and get_close_matches(missing.stem, [Path(found[0]).stem]):
        meant = neighbours[found[0]] / rest
        return f"; did you mean '{meant}'?" if meant.exists() else ""
    files = {file.stem: file for folder in FOLDERS for file in _entries(config_dir() / folder)
             if file.suffix == ".yaml"}  # fmt: skip
    found = get_close_matches(path.stem, sorted(files), n=1)
    return f"; did you mean '{short_path(files[found[0]])}'?" if found else ""


def _is_among(path: Path, others: Collection[Path]) -> bool:
    return bool(others) and path.absolute() in {other.absolute() for other in others}


def _entries(folder: Path) -> list[Path]:
    try:
        return sorted(folder.iterdir())
    except OSError:
        return []


def short_path(file: Path) -> Path:
    """Relative to the current folder where it is in there."""
    here = Path.cwd()
    return file.relative_to(here) if file.is_relative_to(here) else file

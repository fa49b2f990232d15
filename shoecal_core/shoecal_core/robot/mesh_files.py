"""Where the mesh files are that a URDF names: rarely where it says, once it left its package."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path, PurePosixPath

LFS_POINTER = b"version https://git-lfs"
"""Begins a file that stands for one in another store."""
DEPTH = 2
"""How deep meshes are looked for in the URDF's folder, and in those of meshes next to it."""
FOLDERS = "*[Mm]esh*"
"""Of meshes, next to the URDF's: others may be those of other robots."""


def find_mesh(urdf: Path, named: str, folder: Path | None = None) -> Path | None:
    """The file of a mesh.

    Where the URDF says: `package://NAME` in the folders above it. Else in the folder that was
    given, in the URDF's own, or in those of meshes next to it, where it ends most like its name.

    Args:
        urdf: that names it. named: a path, or a URL of the schemes `file` and `package`.
        folder: given by the user.

    Returns:
        None where it is not there.
    """
    scheme, _, rest = named.rpartition("://")
    rest = rest.replace("\\", "/")
    path = PurePosixPath(rest.lstrip("/") if scheme == "package" else rest)
    if scheme == "file" or path.is_absolute():
        places = [Path(path)]
    else:
        places = [above / path for above in list(urdf.resolve().parents)[:-1]]
    there = next((place for place in places if place.is_file()), None)
    if there is not None:
        return there
    own = urdf.resolve().parent
    given = () if folder is None else (folder,)
    for bases in (given, (own,), sorted(own.parent.glob(FOLDERS))):
        found = [file for base in bases for file in _below(base, path.name)]
        if found:
            return min(found, key=lambda one: (-_same(one, path), str(one))).resolve()
    return None


def _below(base: Path, name: str) -> Iterator[Path]:
    """Files of a name in a folder and those below it."""
    for depth in range(DEPTH + 1):
        yield from (one for one in base.glob("*/" * depth + _literal(name)) if one.is_file())


def _literal(name: str) -> str:
    """A name as a pattern that matches it alone."""
    return "".join(f"[{letter}]" if letter in "*?[" else letter for letter in name)


def _same(file: Path, named: PurePosixPath) -> int:
    """How many of the last parts of two paths are the same."""
    count = 0
    for one, other in zip(reversed(file.parts), reversed(named.parts), strict=False):
        if one != other:
            break
        count += 1
    return count

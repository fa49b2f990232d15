"""A layout for other names than the default ones."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

from shoecal_core.errors import ShoecalError
from shoecal_core.files import atomic_write, read_bytes
from shoecal_ros.common.conversions import SOLES

MAX_BYTES = 10_000_000
_NAMESPACE = re.compile(r"(/[A-Za-z_]\w*)*")
_FRAME = re.compile(r"[\w/.-]+")


def placed_layout(file: Path, namespace: str, left_sole_frame: str) -> Path:
    """A layout of shoecal's for a namespace and a fixed frame, in a new temporary folder.

    With default names it is the file itself.

    Args:
        file: the layout with default names.
        namespace: of the nodes, with or without its first slash; empty: none.
        left_sole_frame: fixed frame, with its prefix.

    Raises:
        ShoecalError: for what is no namespace or no frame.
        FileError: where the file cannot be read or the new one not be written.
    """
    inner = namespace.strip("/")
    prefix = f"/{inner}" if inner else ""
    if not _NAMESPACE.fullmatch(prefix):
        raise ShoecalError(f"namespace:={namespace}: not a namespace; for example lab/robot_1")
    if not _FRAME.fullmatch(left_sole_frame):
        raise ShoecalError(f"left_sole_frame:={left_sole_frame}: not a frame; for example l_sole")
    if not prefix and left_sole_frame == SOLES[0]:
        return file
    text = read_bytes(file, MAX_BYTES).decode()
    text = re.sub(rf"\b{SOLES[0]}\b", left_sole_frame, text.replace("/shoe/", f"{prefix}/shoe/"))
    new = Path(tempfile.mkdtemp(prefix="shoecal_layout_")) / file.name
    atomic_write(new, text)
    return new

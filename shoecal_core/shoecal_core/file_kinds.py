"""What was given instead of what was asked for: files of another kind, mistyped keys."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from difflib import get_close_matches

ROBOT_FILE, SHOE_FILE = "a robot file", "a shoe file"
KINDS: Mapping[str, frozenset[str]] = {
    ROBOT_FILE: frozenset(("legs", "posture_rad", "support_range", "weight")),
    SHOE_FILE: frozenset(("height_m", "converter", "unit")),
    "a calibration": frozenset(("channels", "verdict", "made_ns", "robot_hash")),
    "a mapping of tables": frozenset(("tables", "trials")),
    "a mapping of bags": frozenset(("joints", "trials")),
    "a reality file": frozenset(("servo", "cells", "floor", "effects")),
    "a session's own list": frozenset(("runs", "robot", "shoe")),
    "a file of known weights": frozenset(("entries",)),
}
"""By the keys that a whole file of a kind has, and those of other kinds have not all of."""

NODES = "a parameter file of nodes"
"""Its keys are names of nodes."""
XACRO = "is xacro: make a URDF of it (xacro FILE > robot.urdf)"
DECIMAL_POINT = "write a decimal point, not a comma"
"""What is said of files that are xacro, and of numbers with a comma."""
_TABLE = re.compile(r"[^\n:{\[]+[,;\t][^\n:{\[]*\n[-+.\d][^\n:{\[]*[,;\t]")
"""A line of names, then one of numbers."""
_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)


def kind_of(keys: Sequence[str], known: Sequence[str]) -> str:
    """The kind of a file by its keys; empty where it has none, or that with these known keys."""
    for kind, own in KINDS.items():
        if own <= set(keys) and not own <= set(known):
            return kind
    return NODES if keys and all(key.startswith("/") for key in keys) else ""


def wanted(known: Sequence[str]) -> str:
    """What to name instead of a file of another kind, by the keys that are known here."""
    for kind, own in KINDS.items():
        if own <= set(known):
            return f"name {kind} here"
    return "name the one that belongs here"


def meant(given: str, known: Sequence[str]) -> str:
    """What is known of the keys that a mistyped one may have been meant for."""
    if given.isdigit():
        return DECIMAL_POINT
    if near := get_close_matches(given, known, n=1):
        return f"did you mean '{near[0]}'?"
    return f"known: {', '.join(known)}"


def not_yaml(content: bytes) -> str:
    """What a file is that is no YAML mapping; empty where that is not known."""
    text = content[:4096].decode("utf-8", errors="replace").lstrip("\ufeff")
    if not text.strip():
        return "is empty"
    if is_xacro(text):
        return XACRO
    if _TABLE.match(text):
        return "is a table (CSV), no YAML file; name the file of keys and values that belongs here"
    if "<robot" in text:
        return "is a URDF; draft a robot file from it with `shoecal new robot`"
    return ""


def is_mjcf(text: str) -> bool:
    """Whether a description is MuJoCo's; a URDF may hold an element of that name, too."""
    code = _COMMENT.sub("", text)
    return "<mujoco" in code and "<robot" not in code


def is_xacro(text: str) -> bool:
    """Whether a robot's description is one that xacro has still to unfold."""
    # A description that has been unfolded keeps xacro's namespace, and comments of its source.
    code = _COMMENT.sub("", text)
    return "<robot" in code and any(sign in code for sign in ("<xacro:", "${", "$("))

"""Does a message say what to do?"""

from __future__ import annotations

import re

VERBS = (
    "add", "arm", "ask", "build", "calibrate", "call", "check", "choose", "correct", "end",
    "follow", "give", "let", "log", "make", "mend", "name", "plug", "put", "raise", "record",
    "remap", "remove", "restart", "run", "see", "send", "set", "start", "stop", "take", "update",
    "use", "wait",
)  # fmt: skip
_CURE = re.compile(rf"(?:^|[;:,(] (?:then )?)(?:{'|'.join(VERBS)})\b")


def names_a_cure(message: str) -> bool:
    """Whether some part of a message begins with what to do."""
    return _CURE.search(message) is not None

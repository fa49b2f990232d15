"""Sentences on a terminal: broken between words, never within a path or a name."""

from __future__ import annotations

import os
import re

from rich.cells import cell_len
from rich.console import Console
from rich.text import Text

UNBOUNDED = 10_000
"""Columns where nothing is to be broken."""
HANGING = 2
"""How much further in a sentence goes on below its first line."""
_COMMAND = re.compile(r"((Next|Then): )?shoecal ")
"""Begins what is to be copied, and so is in one line."""
_WORD = re.compile(r"\S+(?:(?<=\d) (?:± \S+|%\S*|(?:mm|ms|mrad|rad|N|V|kg|Hz|s)\b\S*))*")
"""What stays in one line: a word, or a figure with its uncertainty and unit."""


def output() -> Console:
    """Standard output: as wide as the terminal or COLUMNS say; elsewhere a sentence is a line."""
    console = Console(highlight=False, emoji=False)
    if console.is_terminal or "COLUMNS" in os.environ:
        return console
    return Console(highlight=False, emoji=False, width=UNBOUNDED)


def say(console: Console, text: str | Text) -> None:
    """Print text; each paragraph is a line of it and keeps its indent.

    Args:
        console: to print on.
        text: nothing in it is markup.
    """
    for paragraph in (Text(text) if isinstance(text, str) else text).split("\n", allow_blank=True):
        words = paragraph.plain.lstrip()
        indent = len(paragraph) - len(words)
        if _COMMAND.match(words):
            console.print(paragraph, soft_wrap=True)
            continue
        rest, left = paragraph[indent:] if indent else paragraph, indent
        while True:
            end = _fitting(rest.plain, console.width - left)
            console.print(Text(" " * left).append_text(rest[:end]), soft_wrap=True)
            rest = rest[len(rest) - len(rest.plain[end:].lstrip()) :]
            if not rest:
                break
            left = indent + HANGING


def _fitting(text: str, room: int) -> int:
    """Letters of the words and figures that fit into so many columns; at least the first."""
    ends = [word.end() for word in _WORD.finditer(text)]
    return max([end for end in ends if cell_len(text[:end]) <= room] or ends[:1], default=0)

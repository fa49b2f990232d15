"""README and docs as what is in them: headings, links, fenced blocks, commands."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROGRAMS = ("shoecal", "make", "ros2", "python", "colcon", "git")
"""With which a line of an indented block is a command."""
_FENCE = re.compile(r"^\s*```(\S*)\s*(.*)$")
_MARK = re.compile(r"^\s*<!-- (not run|fails): (.+) -->\s*$")
_LINK = re.compile(r"(?<!!)\[[^\]]*\]\(([^)\s]+)\)|!\[[^\]]*\]\(([^)\s]+)\)")
_INLINE = re.compile(r"`(make [^`]+)`")


@dataclass(frozen=True)
class Block:
    """A fenced block, or an indented one.

    Attributes:
        page: relative to the checkout.
        line: of its first line.
        language: of the fence; `sh` for indented commands.
        title: `title=` of the fence: the file that the text is to stand in.
        text: without fence and indentation.
        not_run: why it is not run; empty where it is.
        fails: why its last command ends with an error; empty where it does not.
    """

    page: str
    line: int
    language: str
    title: str
    text: str
    not_run: str = ""
    fails: str = ""

    @property
    def commands(self) -> list[str]:
        """One a line; continued lines are joined, comments left out."""
        joined = self.text.replace("\\\n", " ")
        lines = (line.strip() for line in joined.splitlines())
        return [line for line in lines if line and not line.startswith("#")]


@cache
def pages() -> tuple[Path, ...]:
    """README first, then the tutorial: what later pages name is made there."""
    first = [ROOT / "README.md", ROOT / "docs" / "guide" / "tutorial.md"]
    rest = [ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
    return tuple(first + [page for page in rest if page not in first])


@cache
def blocks() -> tuple[Block, ...]:
    """Every block of every page, in order."""
    return tuple(block for page in pages() for block in _blocks(page))


def _blocks(page: Path) -> Iterator[Block]:
    name = str(page.relative_to(ROOT))
    lines = page.read_text().splitlines()
    index, mark = 0, ("", "")
    while index < len(lines):
        line = lines[index]
        if found := _MARK.match(line):
            mark = (found[1], found[2])
        elif fence := _FENCE.match(line):
            end = next(i for i in range(index + 1, len(lines)) if _FENCE.match(lines[i]))
            indent = len(line) - len(line.lstrip())
            text = "\n".join(inner[indent:] for inner in lines[index + 1 : end])
            title = fence[2].removeprefix("title=") if "title=" in fence[2] else ""
            not_run = mark[1] if mark[0] == "not run" else ""
            fails = mark[1] if mark[0] == "fails" else ""
            yield Block(name, index + 2, fence[1], title, text, not_run, fails)
            index, mark = end, ("", "")
        elif line.startswith("    ") and line.split()[0].rpartition("/")[2] in PROGRAMS:
            end = index
            while end < len(lines) and lines[end].startswith("    "):
                end += 1
            text = "\n".join(inner[4:] for inner in lines[index:end])
            yield Block(name, index + 1, "sh", "", text, "stands indented: checked only")
            index = end - 1
        elif line.strip():
            mark = ("", "")
        index += 1


def links(page: Path) -> Iterator[tuple[int, str]]:
    """Line and target of every link and picture."""
    inside = False
    for number, line in enumerate(page.read_text().splitlines(), 1):
        if _FENCE.match(line):
            inside = not inside
        elif not inside:
            for link, picture in _LINK.findall(line):
                yield number, link or picture


@cache
def anchors(page: Path) -> frozenset[str]:
    """Of its headings, as GitHub makes them."""
    found: list[str] = []
    inside = False
    for line in page.read_text().splitlines():
        if _FENCE.match(line):
            inside = not inside
        elif not inside and (heading := re.match(r"#{1,6}\s+(.*)", line)):
            text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading[1]).lower().strip()
            slug = re.sub(r"[^\w\- ]", "", text).replace(" ", "-")
            found.append(slug if slug not in found else f"{slug}-{found.count(slug)}")
    return frozenset(found)


def make_calls() -> Iterator[tuple[str, str]]:
    """Page and command of every call of make, inside blocks or lines of text."""
    for page in pages():
        for call in _INLINE.findall(page.read_text()):
            yield str(page.relative_to(ROOT)), call
    for block in blocks():
        for command in block.commands if block.language == "sh" else ():
            if command.split()[0] == "make":
                yield block.page, command


def words(command: str) -> list[str]:
    """Of one command, its comment left out."""
    return shlex.split(command, comments=True)

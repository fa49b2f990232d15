"""What is shown of one row, and of all of them in a few sentences."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from reliability.row import Result
from reliability.rows import Found

BRIEF = 90
"""Characters of the worst try in a table or a list; all of it stands in the row's own section."""


@dataclass(frozen=True)
class Shown:
    """A row and what is kept of it.

    Attributes:
        found: the row.
        result: what came of its tries.
        present: how many of them ran with the code at hand.
        before: tries that had failed, and were done once more with the same code.
    """

    found: Found
    result: Result
    present: int
    before: Result

    @property
    def share(self) -> str:
        """How many tries, and of how many where that is not all."""
        tried, full = self.result.tried, self.found.row.tries
        return f"{tried:,}" if tried == full else f"{tried:,} of {full:,}"

    @property
    def failed_before(self) -> str:
        """What has failed before with the same code, in words; empty: nothing."""
        told = counted(self.before)
        return f"before, with the same code, {told}" if told else ""


def counted(result: Result) -> str:
    """How many tries failed and what came of the worst; empty: none failed."""
    if not result.failed:
        return ""
    return f"{result.failed:,} of {result.tried:,}: {result.told}"


def brief(text: str) -> str:
    """A text, cut where it is long."""
    return textwrap.shorten(text, BRIEF, placeholder=" …")


def link(key: str) -> str:
    """To the section of a row."""
    return f"[`{key}`](#{key})"


def summary(rows: Mapping[str, Shown]) -> str:
    """All rows in a list of a few lines."""
    tried = {key: one for key, one in rows.items() if one.result.tried}
    whole = sum(one.result.tried == one.found.row.tries for one in tried.values())
    lines = [f"- **{len(rows)} rows**, {whole} of them tried in full."]
    if part := [key for key, one in tried.items() if one.result.tried < one.found.row.tries]:
        lines.append(
            f"- Tried in part: {_listed(f'{link(key)} ({rows[key].share})' for key in part)}."
        )
    if none := [key for key in rows if key not in tried]:
        lines.append(f"- Not tried: {_listed(map(link, none))}.")
    lines += _told("**Failed**", {key: counted(one.result) for key, one in rows.items()})
    if any(one.before.failed for one in rows.values()):
        before = {key: counted(one.before) for key, one in rows.items()}
        lines += _told("Failed before, with the same code,", before)
    lines.append(f"- {_codes(tried)}")
    return "\n".join(lines)


def _told(head: str, told: Mapping[str, str]) -> list[str]:
    lines = [f"    - {link(key)}, {brief(what)}" for key, what in told.items() if what]
    return [f"- {head} in {_rows(len(lines))}{':' if lines else '.'}", *lines]


def _codes(tried: Mapping[str, Shown]) -> str:
    """How many of the tries ran with this code."""
    whole = sum(one.present == one.result.tried for one in tried.values())
    some = [key for key, one in tried.items() if 0 < one.present < one.result.tried]
    none = sum(not one.present for one in tried.values())
    told = [f"all tries of {_rows(whole)}"] if whole else []
    told += [f"{tried[key].present:,} of {link(key)}" for key in some]
    told += [f"none of {_rows(none)} (earlier code)"] if none else []
    return f"**This very code** ran in {_listed(told or ['nothing'])}."


def _rows(count: int) -> str:
    return {0: "none", 1: "1 row"}.get(count, f"{count} rows")


def _listed(words: Iterable[str]) -> str:
    *others, last = words
    return f"{', '.join(others)} and {last}" if others else last

"""Names of joints, cells and frames that a recording writes otherwise than the robot's files."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable

_SIDE = re.compile(r"(^|[^a-z])(left|right|l|r)([^a-z]|$)")
"""A prefix that says a side is part of the name: `left_arm_` is no robot."""


def without_prefix(name: str, known: Collection[str]) -> str | None:
    """The known name behind a robot's prefix such as `nao6/` or `nao6_`; None where there is none.

    A leading `/` is no part of a name.
    """
    name = name.lstrip("/")
    if name in known:
        return name
    for mark in re.finditer("[/_]", name):
        prefix, rest = name[: mark.start()], name[mark.end() :]
        if rest in known and not _SIDE.search(prefix.lower()):
            return rest
    return None


def matched_names(found: Iterable[str], known: Iterable[str]) -> dict[str, str]:
    """Known name by found name: the same, behind a robot's prefix, or alike but for case,
    namespace, `_` and `joint`.

    Names that are alike to several are left out.
    """
    known, found = tuple(known), tuple(dict.fromkeys(found))
    matched = {name: name for name in found if name in known}
    alike: dict[str, list[str]] = {}
    for name in known:
        alike.setdefault(_bare(name), []).append(name)
    by_known: dict[str, list[str]] = {}
    for name in found:
        if name not in matched:
            same = alike.get(_bare(name), [])
            behind = without_prefix(name, known) or (same[0] if len(same) == 1 else "")
            by_known.setdefault(behind, []).append(name)
    taken = {"", *matched}
    return matched | {
        names[0]: name for name, names in by_known.items() if len(names) == 1 and name not in taken
    }


def _bare(name: str) -> str:
    last = name.rpartition("/")[2].lower()
    return re.sub(r"[^a-z0-9]|joint", "", last)

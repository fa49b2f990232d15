"""Whether a layout fits the topics there are: what does not is reported in a line."""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path

from ros.viewers.layouts import Shown, shown_by, split_path

FROM_OTHERS = ("/tf", "/tf_static", "/robot_description", "/diagnostics", "/rosout")
"""Topics that others than shoecal's nodes may have to publish."""


def misfits(
    file: Path, topics: Mapping[str, Sequence[str]], *, ignore: Iterable[str] = FROM_OTHERS
) -> list[str]:
    """What a layout shows that is not there, a line each.

    Args:
        file: the layout.
        topics: types by absolute name, as `Node.get_topic_names_and_types` gives them.
        ignore: topics that need not be there.

    Raises:
        FileError: for a file that is no layout.
    """
    known = dict(topics)
    found = [_misfit(split_path(one, known), known, set(ignore)) for one in shown_by(file)]
    return [f"{file.name}: {reported}" for reported in found if reported]


def _misfit(shown: Shown, topics: dict[str, Sequence[str]], ignore: set[str]) -> str:
    if shown.topic not in topics:
        if shown.topic in ignore:
            return ""
        near = get_close_matches(shown.topic, topics, n=1)
        hint = f"; perhaps {near[0]}" if near else ""
        return f"{shown.plain}: no node publishes this topic{hint}"
    kinds = topics[shown.topic]
    if shown.kind and shown.kind not in kinds:
        return f"{shown.plain}: is {', '.join(kinds)}, drawn as {shown.kind}"
    return "" if not shown.fields else _missing_field(shown, kinds[0])


def _missing_field(shown: Shown, kind: str) -> str:
    for field in shown.fields:
        fields = _fields_of(kind)
        if field not in fields:
            listed = ", ".join(fields) or "none"
            return f"{shown.plain}: {kind} has no field '{field}'; it has {listed}"
        kind = fields[field]
    return ""


def _fields_of(kind: str) -> dict[str, str]:
    """Types of a message's fields; nothing of a number or a text."""
    package, _, name = kind.partition("/")
    if not name:
        return {}
    module = importlib.import_module(f"{package}.msg")
    reported = getattr(module, name.removeprefix("msg/")).get_fields_and_field_types()
    return {field: _element(str(one)) for field, one in reported.items()}


def _element(kind: str) -> str:
    """Type of an array's elements, or the type itself."""
    return kind.removeprefix("sequence<").split(",")[0].split("[")[0].removesuffix(">")

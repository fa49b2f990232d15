"""ROS 2 parameter files: which of their sections are for which node, and settings from them.

A section's key is a node's full name, in which `*` stands for one part and `**` for any number of
parts, as in `/**/planner`. Its first slash may be left out, and namespaces may be nested.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from difflib import SequenceMatcher
from pathlib import Path
from typing import TypeVar

from shoecal_core.errors import FieldError
from shoecal_core.file_kinds import NODES, kind_of
from shoecal_core.files import Fields, read_yaml
from shoecal_core.settings import SettingError, Settings, describe, from_values

S = TypeVar("S", bound=Settings)
PARAMETERS = "ros__parameters"
SLIP = 0.85
"""Likeness of two words from which one is a slip of the other: that of names of real sections is
0.6 at most."""
_WILD = {"*": r"/[^/]+", "**": r"(/[^/]+)*"}


@dataclass(frozen=True)
class ParameterSection:
    """Parameters that a file holds for the nodes that its key matches.

    Attributes:
        key: full name, or pattern of names.
        fields: the parameters.
    """

    key: str
    fields: Fields

    @property
    def last(self) -> str:
        """Last part of the key: a node's own name, or a wildcard."""
        return self.key.rpartition("/")[2]

    @property
    def any_node(self) -> bool:
        """Whether it names no node, as `/**`."""
        return self.last in _WILD

    def matches(self, full_name: str) -> bool:
        """Whether it is for the node of a full name, as `/left_robot/planner`."""
        parts = self.key.strip("/").split("/")
        pattern = "".join(_WILD.get(part, "/" + re.escape(part)) for part in parts)
        return re.fullmatch(pattern, full_name) is not None

    def names(self) -> Iterator[str]:
        """Full names of its parameters, as `planning.horizon`."""
        yield from _names(self.fields, "")


def read_sections(path: Path) -> list[ParameterSection]:
    """All sections, in the order of the file.

    Raises:
        FileError: names the file, the key and the cure.
    """
    fields = read_yaml(path)
    if (kind := kind_of(fields.keys(), ())) not in {"", NODES}:
        form = f"/**/NODE: {{{PARAMETERS}: …}}"
        raise FieldError(path, f"is {kind}, by its keys; name {NODES} here ({form})")
    return [section for key in fields.keys() for section in _sections(fields, key, key)]


def sections_of(path: Path, node: str) -> list[ParameterSection]:
    """Sections for one node, in the order of the file: later ones go before.

    Args:
        path: of the file.
        node: its full name, or without a slash its own name in whatever namespace.

    Raises:
        FileError: where there is none, too.
    """
    every = read_sections(path)
    found = [one for one in every if _is_for(one, node)]
    if not found:
        own = node.rpartition("/")[2]
        raise read_yaml(path).error(
            f"/**/{own}",
            f"is missing: the file sets nothing of node {node}, only of "
            f"{', '.join(one.key for one in every) or 'none'}; add this key",
        )
    return found


def load_settings(cls: type[S], path: Path, node_name: str, section: str) -> S:
    """Read settings from a ROS parameter file.

    Args:
        cls: the Settings class.
        path: YAML of the form `/**/node_name: {ros__parameters: {section: {key: value}}}`.
        node_name: whose parameters to take; with its namespace where that matters.
        section: of them; where it is left out everything has its default.

    Raises:
        FileError: names the file, the key and the cure.
    """
    values: dict[str, object] = {}
    for block in sections_of(path, node_name):
        _check_keys(block.fields, section, [entry.name for entry in describe(cls)])
        dotted = f"{section}."
        own = [(block.fields, key) for key in block.fields.keys() if key.startswith(dotted)]
        if section in block.fields:
            entries = block.fields.mapping(section)
            own += [(entries, key) for key in entries.keys()]
        for fields, key in own:
            values[key.removeprefix(dotted)] = fields.value(key)
            try:
                from_values(cls, values)
            except SettingError as error:
                raise fields.error(key, error.problem) from error
    return from_values(cls, values)


def _check_keys(fields: Fields, section: str, names: Collection[str]) -> None:
    """Refuse what would be passed over in silence: settings outside their section, and slips."""
    for key in fields.keys():
        if key in names:
            raise fields.error(key, f"stands outside '{section}'; write '{section}.{key}'")
        if key != section and _alike(key.partition(".")[0], section):
            raise fields.error(key, f"is no section; did you mean '{section}'?")


def _alike(one: str, other: str) -> bool:
    """Words that differ by a slip."""
    return one != other and SequenceMatcher(a=one, b=other).ratio() >= SLIP


def _is_for(section: ParameterSection, node: str) -> bool:
    if "/" in node:
        return section.matches(node)
    return section.any_node or section.last == node


def _sections(fields: Fields, key: str, path: str) -> Iterator[ParameterSection]:
    block = fields.mapping(key)
    inner = block.keys()
    for name in inner:
        if _alike(name, PARAMETERS):
            raise block.error(name, f"write '{PARAMETERS}', with two underscores")
    if PARAMETERS in inner or not inner:
        block.only(PARAMETERS)
        yield ParameterSection(path, block.mapping(PARAMETERS))
        return
    for name in inner:
        yield from _sections(block, name, f"{path}/{name}")


def _names(fields: Fields, prefix: str) -> Iterator[str]:
    for key in fields.keys():
        if key in fields and isinstance(fields.value(key), dict):
            yield from _names(fields.mapping(key), f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}"

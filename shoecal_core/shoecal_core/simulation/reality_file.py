"""Reading reality files: a complete one first, then one that changes only the keys it names."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, TypeVar, get_args, get_origin, get_type_hints

from shoecal_core.files import Fields, read_yaml
from shoecal_core.simulation.effects.registry import read_effect
from shoecal_core.simulation.reality import Bounds, Choices, NamedNumbers, PlantVariation

FORMAT = 1
Section = TypeVar("Section")


def load_reality(default: Path, override: Path | None = None) -> PlantVariation:
    """Read a reality.

    Args:
        default: a file in which every key stands.
        override: a file that changes the keys it names. A table of names and the list of
            effects count as one key each: naming one replaces it whole.

    Raises:
        FileError: for anything missing, unknown, mistyped or out of bounds.
    """
    complete = _read(default, None)
    return complete if override is None else _read(override, complete)


def _read(path: Path, base: PlantVariation | None) -> PlantVariation:
    fields = read_yaml(path)
    fields.format(FORMAT)
    return _section(fields, PlantVariation, base, "format")


def _section(fields: Fields, kind: type[Section], base: Section | None, *others: str) -> Section:
    """One section: what the file names, else what the base holds."""
    hints = get_type_hints(kind, include_extras=True)
    fields.only(*others, *hints)
    return kind(
        **{
            name: _entry(fields, name, hint, None if base is None else getattr(base, name))
            for name, hint in hints.items()
        }
    )


def _entry(fields: Fields, name: str, hint: Any, base: Any) -> object:
    """One entry of a section, read as its declared type says."""
    if base is not None and name not in fields.keys():
        return base
    if hint is str:
        return fields.text(name)
    if hint is bool:
        return fields.boolean(name)
    if get_origin(hint) is tuple:
        return tuple(read_effect(item) for item in fields.items(name))
    if get_origin(hint) is Annotated:
        return _bounded(fields, name, *get_args(hint))
    return _section(fields.mapping(name), hint, base)


def _bounded(fields: Fields, name: str, kind: type[Any], bounds: Bounds | Choices) -> object:
    """A number or a table of numbers, within bounds, or one of some words."""
    if isinstance(bounds, Choices):
        return fields.choice(name, dict.fromkeys(bounds.words))
    if kind is NamedNumbers:
        block = fields.mapping(name)
        return NamedNumbers(dict(_rows(block, bounds)), block.path, block.prefix)
    if kind is int:
        fields.integer(name)
    return kind(_number(fields, name, bounds))


def _rows(fields: Fields, bounds: Bounds) -> Iterator[tuple[str, tuple[float, ...]]]:
    for name in fields.keys():
        if bounds.width == 1:
            yield name, (_number(fields, name, bounds),)
        else:
            yield name, tuple(fields.array(name, (bounds.width,)).tolist())


def _number(fields: Fields, name: str, bounds: Bounds) -> float:
    return fields.number(name, minimum=bounds.minimum, above=bounds.above, maximum=bounds.maximum)

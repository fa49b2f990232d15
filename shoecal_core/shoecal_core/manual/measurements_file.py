"""Measurements as a file: rewritten whole after every reading."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import FieldError, FileError, NameNotFoundError, ShoecalError
from shoecal_core.files import Fields, atomic_write, read_yaml
from shoecal_core.manual.loads import CELLS, KINDS, Load
from shoecal_core.manual.measurements import EntryError, LoadReading, Measurements
from shoecal_core.shoe.shoe import FEET, Shoe

FORMAT = 1


def save_measurements(measurements: Measurements, path: Path) -> None:
    """Write measurements, atomically: YAML, one line an entry, quick enough for each reading."""
    shoe = measurements.shoe
    head = {
        "format": FORMAT,
        "kind": measurements.kind,
        "shoe": shoe.name,
        "shoe_hash": shoe.digest,
        "unit": shoe.unit,
    }
    lines = [f"{key}: {_flow(value)}" for key, value in head.items()]
    lines.append("entries:" if measurements.entries else "entries: []")
    lines += [f"- {_flow(_to_yaml(shoe, entry))}" for entry in measurements.entries]
    atomic_write(path, "\n".join(lines) + "\n")


def load_measurements(path: Path, kind: str, shoe: Shoe) -> Measurements:
    """Read measurements of a kind.

    Raises:
        FileError: for anything missing, mistyped or impossible, and for readings of another
            shoe, kind or unit.
    """
    fields = read_yaml(path)
    fields.format(FORMAT)
    fields.only("format", "kind", "shoe", "shoe_hash", "unit", "entries")
    found = fields.choice("kind", dict.fromkeys(KINDS))
    if found != kind:
        raise fields.error("kind", f"holds readings of '{found}', wanted are those of '{kind}'")
    _check_shoe(fields, shoe)
    items = fields.items("entries")
    try:
        entries = tuple(_from_yaml(kind, shoe, item) for item in items)
        return Measurements(kind, shoe, entries, Path(path))
    except EntryError as error:
        raise items[error.index].error(error.key, error.problem) from error
    except FileError:
        raise
    except ShoecalError as error:
        raise FieldError(path, str(error)) from error


def _check_shoe(fields: Fields, shoe: Shoe) -> None:
    name = fields.text("shoe")
    if name != shoe.name:
        raise fields.error("shoe", f"readings of shoe '{name}', but {shoe.path} is '{shoe.name}'")
    if fields.text("shoe_hash") != shoe.digest:
        raise fields.error(
            "shoe_hash",
            f"{shoe.path} has changed since: give the shoe file of then, or, where neither cells "
            f"nor holes have changed, write its hash of now here: {shoe.digest}",
        )
    unit = fields.text("unit")
    if unit != shoe.unit:
        raise fields.error("unit", f"readings in {unit}, but {shoe.path} has them in {shoe.unit}")


def _flow(value: object) -> str:
    """A value as YAML in one line: JSON is that."""
    return json.dumps(value, ensure_ascii=False, allow_nan=False)


def _to_yaml(shoe: Shoe, entry: LoadReading) -> dict[str, object]:
    load = entry.load
    place: dict[str, object] = {"cell": load.place} if load.alone else {"foot": FEET[load.foot]}
    if load.place and not load.alone:
        place["hole"] = load.place
    names = _names(shoe, load.foot)
    return {
        **place,
        "mass_kg": load.mass,
        "count": entry.count,
        "made_ns": entry.made_ns,
        "mean": _by_name(names, entry.mean),
        "std": _by_name(names, entry.std),
    }


def _from_yaml(kind: str, shoe: Shoe, fields: Fields) -> LoadReading:
    place = ("cell",) if kind == CELLS else ("foot", "hole")
    fields.only(*place, "mass_kg", "count", "made_ns", "mean", "std")
    if kind == CELLS:
        name = fields.text("cell")
        try:
            load = Load(int(shoe.foot[shoe.index(name)]), name, fields.number("mass_kg"))
        except NameNotFoundError as error:
            raise fields.error("cell", str(error)) from error
    else:
        foot = FEET.index(fields.choice("foot", dict.fromkeys(FEET)))
        load = Load(foot, fields.text("hole", ""), fields.number("mass_kg"))
    names = _names(shoe, load.foot)
    return LoadReading(
        load,
        _values(fields, "mean", names),
        _values(fields, "std", names) if "std" in fields else np.full(len(names), math.nan),
        fields.integer("count", 1, minimum=1),
        fields.integer("made_ns", 0, minimum=0),
    )


def _names(shoe: Shoe, foot: int) -> tuple[str, ...]:
    """Names of a foot's cells, as its block of the shoe file has them."""
    return tuple(shoe.names[index].split("/", 1)[1] for index in shoe.of_foot(foot))


def _by_name(names: tuple[str, ...], values: FloatArray) -> dict[str, float]:
    pairs = zip(names, values.tolist(), strict=True)
    return {name: value for name, value in pairs if not math.isnan(value)}


def _values(fields: Fields, key: str, names: tuple[str, ...]) -> FloatArray:
    values = fields.mapping(key)
    values.only(*names)
    return np.array([values.number(name, math.nan) for name in names])

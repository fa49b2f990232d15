"""Where an effect sits: the names that its item of a reality file lists."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.errors import FieldError, instead
from shoecal_core.files import Fields
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import FEET, Shoe
from shoecal_core.simulation.reality import ALL, BASE
from shoecal_core.simulation.sampled_parts import link_names

_AREAS = (*FEET, ALL)


def read_feet(fields: Fields) -> tuple[str, ...]:
    """The feet that `location` lists; `all` means both.

    Raises:
        FieldError: when it lists anything else.
    """
    names = fields.texts("location")
    if names == [ALL]:
        return FEET
    for name in names:
        if name not in FEET:
            raise fields.error("location", f"'{name}' is not one of: {', '.join(FEET)}, {ALL}")
    return _once(fields, names)


def read_shift(fields: Fields) -> tuple[float, float, float]:
    """Along x and y [m] and about z [rad]; what is not named is zero."""
    dx, dy = (fields.number(key, 0.0, minimum=-0.1, maximum=0.1) for key in ("dx_m", "dy_m"))
    return dx, dy, fields.number("dtheta_rad", 0.0, minimum=-0.5, maximum=0.5)


@dataclass(frozen=True)
class Channels:
    """Channels of a shoe that is not known yet, and where they were written, for messages.

    Attributes:
        names: channels or feet, or `all`.
        path, field: where `location` stands.
    """

    names: tuple[str, ...]
    path: Path
    field: str

    @classmethod
    def read(cls, fields: Fields, *, count: int | None = None, areas: bool = False) -> Channels:
        """The names that `location` lists.

        Args:
            fields: the item.
            count: how many channels there must be; None for at least one.
            areas: whether feet and `all` may be named too.

        Raises:
            FieldError: when it lists anything else.
        """
        names = _once(fields, fields.texts("location"))
        if count is not None and len(names) != count:
            raise fields.error("location", f"must name {count} channels, got {len(names)}")
        for name in names:
            if name in _AREAS and not areas:
                raise fields.error("location", f"'{name}' is no channel; name one (foot/cell)")
        return cls(names, fields.path, f"{fields.prefix}.location")

    def every(self, shoe: Shoe) -> IntArray:
        """(k,) indices of the channels, whatever they read, in the order of their names here.

        Of a foot, those of vertical force: its cells, or that axis of its six-axis sensor.

        Raises:
            FieldError: for a channel that the shoe lacks.
        """
        chosen: list[int] = []
        for name in self.names:
            if name in _AREAS:
                feet = FEET if name == ALL else (name,)
                chosen += [
                    index
                    for index in range(len(shoe.names))
                    if FEET[shoe.foot[index]] in feet and shoe.columns[index, 0] == 1.0
                ]
            elif name in shoe.names:
                chosen.append(shoe.names.index(name))
            else:
                raise self.error(f"there is no channel '{name}' ({instead(name, shoe.names)})")
        return np.array(list(dict.fromkeys(chosen)), dtype=np.int64)

    def forces(self, shoe: Shoe) -> IntArray:
        """(k,) indices of the channels, which must read forces.

        Raises:
            FieldError: for a channel that the shoe lacks, or that reads a torque.
        """
        for name in self.names:
            if name in shoe.names and shoe.torque[shoe.names.index(name)]:
                raise self.error(f"'{name}' reads a torque; this effect needs a force's channel")
        return self.every(shoe)

    def cells(self, shoe: Shoe) -> IntArray:
        """(k,) indices of one-axis load cells.

        Raises:
            FieldError: for a channel that the shoe lacks, or an axis of a six-axis sensor.
        """
        chosen = self.every(shoe)
        for index in chosen:
            if not np.all(shoe.columns[shoe.of_foot(shoe.foot[index]), 0] == 1.0):
                raise self.error(
                    f"'{shoe.names[index]}' is an axis of a six-axis sensor; this effect needs a "
                    "one-axis cell"
                )
        return chosen

    def error(self, problem: str) -> FieldError:
        """The error to raise for this location."""
        return FieldError(self.path, problem, field=self.field)


@dataclass(frozen=True)
class Parts:
    """Links or joints of a robot that is not known yet, and where they were written.

    Attributes:
        names: of the URDF; links: `base` for the root, joints: `all` for those of the legs.
        kind: `link` or `joint`.
        path, field: where `location` stands.
    """

    names: tuple[str, ...]
    kind: str
    path: Path
    field: str

    @classmethod
    def read(cls, fields: Fields, kind: str) -> Parts:
        """The names that `location` lists.

        Raises:
            FieldError: when it lists none, or one twice.
        """
        names = _once(fields, fields.texts("location"))
        return cls(names, kind, fields.path, f"{fields.prefix}.location")

    def mask(self, robot: Robot) -> FloatArray:
        """1 for those that are listed, else 0: (L,) of all links or (m,) of all joints.

        Raises:
            FieldError: for one that the robot lacks.
        """
        known = robot.joint_names if self.kind == "joint" else link_names(robot)
        mask = np.zeros(len(known))
        for name in self.names:
            if name == ALL and self.kind == "joint":
                mask[robot.moved] = 1.0
            elif name == BASE and self.kind == "link":
                mask[0] = 1.0
            elif name in known:
                mask[known.index(name)] = 1.0
            else:
                raise FieldError(
                    self.path,
                    f"there is no {self.kind} '{name}' ({instead(name, known)})",
                    field=self.field,
                )
        return mask


def _once(fields: Fields, names: list[str]) -> tuple[str, ...]:
    if not names:
        raise fields.error("location", "names nothing; name at least one")
    if len(set(names)) < len(names):
        raise fields.error("location", "names one twice; name each once")
    return tuple(names)

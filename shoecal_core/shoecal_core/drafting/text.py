"""Drafts as YAML text, each block below the line that says what to check of it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from shoecal_core.drafting.draft import Draft
from shoecal_core.drafting.notes import Note, robot_notes, shoe_notes
from shoecal_core.drafting.simulated import LARGE_DEFLECTION, LARGE_KG, small_deflection
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import AXES, FEET

ROBOT_TITLE = "Draft of {} by `shoecal new robot`. Lengths in m, angles in rad, masses in kg."
SHOE_TITLE = (
    "Draft of what {} stands on, by `shoecal new robot`. Sole frames: x forward, y left, z up; "
    "lengths in m."
)
COMMENT_WIDTH = 96
WORDS = {"y", "n", "yes", "no", "on", "off", "true", "false", "null", "nan", "inf"}
"""What YAML takes for something else than text."""
CORNERS = ("front_left", "front_right", "rear_left", "rear_right")
"""Of a sole, as `Draft.cells` has them."""
SHOE_HEIGHT = 0.02
"""m; of a shoe that was not measured yet."""
USUAL_FRICTION = 0.6
"""Of clean soles on a floor of wood or linoleum."""
PLATE_SHARE = 0.009
"""Mass of one plate over the robot's, as in shoes that were built."""


@dataclass
class _Page:
    lines: list[str]
    notes: Sequence[Note]

    def say(self, field: str) -> None:
        """The comments of a field."""
        for note in self.notes:
            if note.field == field:
                self.lines += _comment(f"{note.found} CHECK: {note.look}")

    def __str__(self) -> str:
        return "\n".join(self.lines) + "\n"


def robot_text(draft: Draft, urdf: str) -> str:
    """ROBOT.yaml.

    Args:
        urdf: the URDF as the robot file shall name it.
    """
    page = _Page(_comment(ROBOT_TITLE.format(draft.name)), robot_notes(draft))
    page.lines += ["format: 1", f"name: {_text(draft.name)}", f"urdf: {_text(urdf)}", ""]
    page.say("weight")
    page.lines += [f"weight: {{mass_kg: {draft.mass:.3f}, std_kg: {0.01 * draft.mass:.3f}}}", ""]
    page.say("feet")
    page.lines.append("feet:")
    for foot, (side, sole) in enumerate(zip(FEET, draft.soles, strict=True)):
        rpy = pin.rpy.matrixToRpy(sole.placement.rotation)
        page.lines += [
            f"  {side}:",
            f"    link: {_text(sole.link)}",
            f"    sole_xyz_m: {_row(sole.placement.translation, 5)}",
            f"    sole_rpy_rad: {_row(rpy, 9)}",
            f"    outline_m: {_rows(sole.outline)}",
            f"    sensing_polygon_m: {_rows(draft.polygon(foot))}",
        ]
    page.lines.append("")
    page.say("legs")
    page.lines += ["legs:", *(f"  - {_text(name)}" for name in draft.leg_names), ""]
    if draft.held:
        page.say("optional_joints")
        page.lines += ["optional_joints:", *(f"  - {_text(name)}" for name in draft.held), ""]
    page.say("posture_rad")
    page.lines += ["posture_rad:"]
    page.lines += [f"  {_text(name)}: {angle:g}" for name, angle in draft.posture.items()]
    page.lines.append("")
    page.say("support_range")
    page.lines.append("support_range:")
    span = draft.support_range
    for key, row in (("dx_m", span.dx), ("dy_m", span.dy), ("dtheta_rad", span.dtheta)):
        low, high, step, neutral = row
        page.lines.append(
            f"  {key}: {{lower: {low:g}, upper: {high:g}, step: {step:g}, neutral: {neutral:g}}}"
        )
    page.lines.append("")
    page.say("friction")
    page.lines += [f"friction: {USUAL_FRICTION:g}", f"tilt_max_rad: {Robot.tilt_max:g}", ""]
    page.say("joint_deflection")
    joint = LARGE_DEFLECTION if draft.mass > LARGE_KG else small_deflection(draft.strength)
    page.lines += [f"joint_deflection: {{sag_rad: {joint.sag:g}, play_rad: {joint.play:g}}}", ""]
    page.say("capsules")
    _add_capsules(page.lines, draft)
    return str(page)


def _add_capsules(lines: list[str], draft: Draft) -> None:
    lines.append("capsules:")
    lines += [
        f"  - {{name: {capsule.name}, link: {_text(capsule.link)}, "
        f"from_m: {_row(capsule.start, 4)}, to_m: {_row(capsule.end, 4)}, "
        f"radius_m: {capsule.radius:.4f}}}"
        for capsule in draft.capsules
    ]
    lines.append("collision_pairs:")
    lines += [f"  - {{a: {a}, b: {b}}}" for a, b in draft.pairs]


def shoe_text(draft: Draft) -> str:
    """SHOE.yaml: the feet's own sensors, or shoes with four cells each."""
    page = _Page(_comment(SHOE_TITLE.format(draft.name)), shoe_notes(draft))
    six_axis = draft.six_axis[0] is not None
    worn = not six_axis and draft.own_cells is None
    unit, span = ("N", 50.0 * draft.mass) if six_axis else ("V", 5.0)
    kind = "shoe" if worn else "feet"
    page.lines += ["format: 1", f"name: {_text(f'{draft.name}_{kind}')}", f"unit: {unit}"]
    page.say("height_m")
    page.lines.append(f"height_m: {SHOE_HEIGHT if worn else 0.0:g}")
    page.say("converter")
    page.lines += [f"converter: {{lowest: {-span:.0f}, highest: {span:.0f}}}", "", "feet:"]
    for foot, side in enumerate(FEET):
        page.lines.append(f"  {side}:")
        if foot == 0:
            page.say("plates")
        page.lines += _plates(draft, foot, worn=worn)
        if foot == 0:
            page.say("six_axis" if six_axis else "cells")
        page.lines += _six_axis(draft, foot) if six_axis else _cells(draft, foot)
    return str(page)


def _plates(draft: Draft, foot: int, *, worn: bool) -> list[str]:
    mass = PLATE_SHARE * draft.mass if worn else 0.0
    outline = draft.soles[foot].outline
    x, y = 0.5 * (outline.min(axis=0) + outline.max(axis=0)) if worn else 0.0 * outline[0]
    lines = ["    plates:"]
    for part, share in (("above", 0.75), ("below", 0.2)):
        z = share * SHOE_HEIGHT if worn else 0.0
        lines += [
            f"      mass_{part}_kg: {mass:.3f}",
            f"      com_{part}_m: {_row((x, y, z), 4)}",
        ]
    return lines


def _cells(draft: Draft, foot: int) -> list[str]:
    names = CORNERS if draft.own_cells is None else draft.own_cells[foot].names
    return ["    cells:"] + [
        f"      - {{name: {_text(name)}, position_m: {_row(place, 4)}, polarity: 0}}"
        for name, place in zip(names, draft.cells(foot), strict=True)
    ]


def _six_axis(draft: Draft, foot: int) -> list[str]:
    sensor = draft.six_axis[foot]
    assert sensor is not None
    signs = sensor.signs or (1, 1, 1)
    lines = ["    six_axis:", f"      origin_m: {_row(sensor.origin, 4)}", "      axes:"]
    for axis in AXES:
        sign = signs["xyz".index(axis[1])]
        lines.append(f"        - {{axis: {axis}, polarity: {sign}, nominal_gain: {sign:.1f}}}")
    return lines


def _comment(text: str) -> list[str]:
    lines = [""]
    for word in text.split():
        if lines[-1] and len(lines[-1]) + 1 + len(word) > COMMENT_WIDTH:
            lines.append("")
        lines[-1] += f" {word}"
    return [f"#{line}" for line in lines]


def _row(values: ArrayLike, digits: int) -> str:
    return "[" + ", ".join(_number(value, digits) for value in np.asarray(values)) + "]"


def _rows(values: Iterable[ArrayLike]) -> str:
    return "[" + ", ".join(_row(value, 4) for value in values) + "]"


def _number(value: float, digits: int) -> str:
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def _text(value: str) -> str:
    """A name, quoted where YAML would take it for something else."""
    plain = value.replace("_", "").replace("-", "").replace(".", "").replace("/", "")
    if (
        plain.isascii()
        and plain.isalnum()
        and not plain[0].isdigit()
        and plain.lower() not in WORDS
    ):
        return value
    return "'" + value.replace("'", "''") + "'"

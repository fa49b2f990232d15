"""What was found where in a URDF, and what somebody who knows the robot has to look at."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shoecal_core.drafting.draft import Draft
from shoecal_core.drafting.plausible import doubts


@dataclass(frozen=True)
class Note:
    """One thing to check.

    Attributes:
        field: of the robot file or the shoe file.
        found: what is there and where it comes from.
        look: what to check.
    """

    field: str
    found: str
    look: str


def robot_notes(draft: Draft) -> list[Note]:
    """Of the robot file, in the order of its fields."""
    notes = [
        Note(
            "weight",
            f"{draft.mass:.3f} kg is the sum of the URDF's masses.",
            "weigh the robot, without shoes, with battery; std_kg is the scale's.",
        ),
        *(
            Note("urdf", f"{doubt}.", "the <inertial> of these links; frames have none.")
            for doubt in doubts(draft.body, draft.legs)
        ),
        *_feet(draft),
        Note(
            "legs",
            f"{len(draft.leg_names)} joints of the two like chains that reach lowest.",
            "none is missing, none is locked; joints with one motor belong to shared_motors.",
        ),
    ]
    if not draft.ankles_roll:
        notes.append(
            Note(
                "legs",
                "The feet have no ankle roll: while both soles stay flat, the CoP cannot move "
                "sideways, so `shoecal plan` refuses them.",
                "the URDF leaves no joint out; else use known weights (`shoecal manual`).",
            )
        )
    if draft.crossed:
        notes.append(
            Note(
                "legs",
                f"{'; '.join(draft.crossed)}: the limits are each other's with the wrong sign.",
                "which of them the robot has, and correct the other one in the URDF.",
            )
        )
    if draft.weak_joints:
        notes.append(
            Note(
                "legs",
                f"{', '.join(draft.weak_joints)}: effort or velocity limit of the URDF is 0.",
                "give the motors' limits there, or nothing can be planned.",
            )
        )
    if draft.unlimited:
        notes.append(
            Note(
                "legs",
                f"{', '.join(draft.unlimited)}: no limits in the URDF, so half a turn either way.",
                "give the motors' limits there (type revolute, lower and upper).",
            )
        )
    if draft.beyond_turns:
        notes.append(
            Note(
                "legs",
                f"{', '.join(draft.beyond_turns)}: limits in the URDF are more than a turn and a "
                "half either way.",
                "they are in rad, not in degrees.",
            )
        )
    if draft.body.locked:
        notes.append(
            Note(
                "urdf",
                f"{', '.join(draft.body.locked)}: both limits are one angle, so fixed at it.",
                "it is locked there; else give its limits in the URDF.",
            )
        )
    if draft.held:
        notes.append(
            Note(
                "optional_joints",
                f"{', '.join(draft.held)}: of closed chains, held where posture_rad has them.",
                "they do not move while the robot is calibrated; a driver need not report them.",
            )
        )
    notes.append(_posture(draft))
    notes.append(
        Note(
            "support_range",
            "Drafted from the legs' length, the soles' width and the hips' yaw limits.",
            "the robot can stand at its ends; `shoecal plan` leaves out what it cannot reach.",
        )
    )
    notes += [
        Note(
            "friction",
            "Usual values, not of this robot: least friction between soles and floor, largest tilt "
            "of the torso.",
            "the soles do not slip at it, and the robot bears that tilt.",
        ),
        Note(
            "joint_deflection",
            "Usual of a robot of this weight: sag of a joint at its torque limit; play of gears "
            "and error of its zero together.",
            "measure both at an ankle; the looser the joints, the less motions may ask for.",
        ),
    ]
    missing = ""
    if {"left_thigh", "left_shank"} - {capsule.name for capsule in draft.capsules}:
        missing = "Thighs or shanks have no shape in the URDF, so no capsule. "
    if draft.missing_meshes:
        more = len(draft.missing_meshes) - 1
        rest = f", and {more} more are of no use" if more else ""
        missing = f"{missing}Mesh {draft.missing_meshes[0]}{rest}. "
    notes.append(
        Note(
            "capsules",
            f"{missing}Thighs and shanks: around their shapes, as far as there is room between "
            "the legs; feet: along their inner edges.",
            "they cover covers and cables, and are apart in posture_rad: `shoecal plan` checks it.",
        )
    )
    return notes


def _feet(draft: Draft) -> list[Note]:
    forward = "".join(f"{value:+.0f} " for value in draft.legs.forward).strip()
    source_of_left = (
        "by the joints' names" if draft.legs.named else "by the base's x axis, as no name says"
    )
    left = draft.soles[0]
    length, width = np.ptp(left.outline, axis=0)
    source = "Measured soles" if draft.measured else "Lowest faces"
    notes = [
        Note(
            "feet",
            f"{source} of {left.link} and {draft.soles[1].link}, below their last joints; left "
            f"was found {source_of_left}, forward is ({forward}) of the base.",
            f"the sole is {1e3 * length:.0f} mm long and {1e3 * width:.0f} mm wide, "
            f"{1e3 * left.height:.1f} mm below the ankle; outlines hold what touches the floor.",
        ),
        Note(
            "feet",
            "sensing_polygon_m: the outline made smaller.",
            "the foot does not tip wherever in it the CoP is; it lies between the cells.",
        ),
    ]
    if width > length:
        notes.append(
            Note(
                "feet",
                "The soles are wider than long.",
                "sole_rpy_rad points x to the toes, and meshes are not turned.",
            )
        )
    return notes


def _posture(draft: Draft) -> Note:
    arms = ""
    if draft.clipped:
        arms = f" {', '.join(draft.clipped)} cannot be zero: nearest limit."
    if draft.keyframe:
        return Note(
            "posture_rad",
            f"Begins at keyframe {draft.keyframe}: in the zero pose the robot does not stand.",
            "both soles are level there, the CoM above them; nothing there is at a limit.",
        )
    return Note(
        "posture_rad",
        f"Knees bent, soles level, CoM over the soles; all else at zero.{arms}",
        "arms are clear of the legs; knees bend to the right side; nothing there is at a limit.",
    )


def shoe_notes(draft: Draft) -> list[Note]:
    """Of the shoe file, in the order of its fields."""
    own = Note(
        "height_m", "0: the robot stands on its own feet.", "nothing is put on under the soles."
    )
    range_ = Note("converter", "-5 to 5 V, a guess.", "ends of the readings, in the unit above.")
    if draft.six_axis[0] is not None:
        return [
            own,
            Note("converter", "Five times the weight.", "the sensor's range in newtons."),
            Note(
                "plates",
                "None: the URDF's own links below the sensors; their weight goes into the offsets.",
                "the sensors' readings are forces of the floor on the foot, not the other way.",
            ),
            *_sensors(draft),
        ]
    if draft.own_cells is not None:
        return [
            own,
            range_,
            Note(
                "plates",
                "None: the weight of what lies below the cells goes into the offsets.",
                "the cells lie in the robot's own soles.",
            ),
            Note(
                "cells",
                f"{' and '.join(', '.join(foot.names) for foot in draft.own_cells)} of the URDF.",
                "rename them as your bag or device does; polarity 0 means that the sign is not "
                "known.",
            ),
        ]
    return [
        Note("height_m", "20 mm, a guess.", "measure from the floor up to the robot's own sole."),
        range_,
        Note("plates", "0.9 % of the robot each, a guess.", "weigh them."),
        Note(
            "cells",
            "Under the soles' corners, for want of a shoe.",
            "measure where each cell carries; polarity 0 means that the sign is not known.",
        ),
    ]


def _sensors(draft: Draft) -> list[Note]:
    sensors = [sensor for sensor in draft.six_axis if sensor is not None]
    notes = [
        Note(
            "six_axis",
            f"{' and '.join(sensor.name for sensor in sensors)} of the URDF, in the sole frame.",
            "origin_m is where the sensor measures its moments.",
        )
    ]
    if any(sensor.signs is None for sensor in sensors):
        notes.append(
            Note(
                "six_axis",
                "Its axes are not parallel to the sole's.",
                "turn the readings into the sole's axes before shoecal sees them.",
            )
        )
    if draft.parallel_sensors:
        notes.append(
            Note(
                "six_axis",
                f"{', '.join(draft.parallel_sensors)} each carry a part of their foot.",
                "shoecal reads one sensor a foot: publish the sum of a foot's wrenches about "
                "origin_m.",
            )
        )
    if draft.other_sensors:
        notes.append(
            Note(
                "six_axis",
                f"{', '.join(draft.other_sensors)} measure above the ankle.",
                "they are not used: joints lie between them and the sole.",
            )
        )
    return notes

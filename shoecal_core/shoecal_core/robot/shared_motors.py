"""Joints that one motor turns: named in the robot file, or by the URDF's <mimic> elements."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from shoecal_core.files import Fields
from shoecal_core.robot.robot import SharedMotor
from shoecal_core.robot.urdf import Mimic, UrdfError

_TOLERANCE = 1e-9
"""Ratios nearer to each other are the same."""


def read_shared_motors(
    fields: Fields, names: Sequence[str], urdf: Path, mimics: Mapping[str, Mimic]
) -> tuple[SharedMotor, ...]:
    """Every joint that follows another one, each once.

    Args:
        fields: of the robot file; its `shared_motors` may repeat what the URDF says.
        names: the joints, in the order of arrays of joints.
        urdf: where `mimics` stand.
        mimics: the URDF's followers.

    Raises:
        UrdfError: for followers of followers in the URDF, and what else it says amiss of them.
        FieldError: for those of the robot file, and where it and the URDF contradict.
    """
    motors = [_listed(item, names) for item in fields.items("shared_motors")] if (
        "shared_motors" in fields
    ) else []  # fmt: skip
    followers = [motor.joint for motor in motors]
    for motor in motors:
        if motor.leader in followers or followers.count(motor.joint) > 1:
            raise fields.error(
                "shared_motors",
                f"'{names[motor.joint]}' must follow one joint, which follows none itself",
            )
    for name, mimic in mimics.items():
        meant = _mimicked(urdf, name, mimic, names)
        if meant.joint not in followers:
            motors.append(meant)
        elif not any(_same(meant, motor) for motor in motors):
            raise fields.error(
                "shared_motors",
                f"'{name}' follows another joint or at another ratio than in {urdf.name} "
                f"(<mimic>: '{mimic.leader}', {mimic.multiplier:g}); make them agree",
            )
    followers = [motor.joint for motor in motors]
    for motor in motors:
        if motor.leader in followers:
            raise UrdfError(
                urdf,
                f"follows '{names[motor.leader]}', which follows another joint itself; name the "
                "joint whose motor it is",
                field=f"joint {names[motor.joint]}",
            )
    return tuple(motors)


def _listed(item: Fields, names: Sequence[str]) -> SharedMotor:
    item.only("joint", "leader", "ratio")
    joint, leader = (
        names.index(item.choice(key, dict.fromkeys(names))) for key in ("joint", "leader")
    )
    ratio = item.number("ratio")
    if ratio == 0.0:
        raise item.error("ratio", "a joint that never turns is no follower; make it fixed")
    return SharedMotor(joint, leader, ratio)


def _mimicked(urdf: Path, name: str, mimic: Mimic, names: Sequence[str]) -> SharedMotor:
    field = f"joint {name}"
    if mimic.leader not in names or mimic.leader == name:
        raise UrdfError(
            urdf,
            f"mimics '{mimic.leader}', which is no other moving joint; correct it",
            field=field,
        )
    if mimic.offset != 0.0 or mimic.multiplier == 0.0:
        raise UrdfError(
            urdf,
            f"mimics with multiplier {mimic.multiplier:g} and offset {mimic.offset:g}; only a "
            "multiplier other than 0 and no offset are understood: turn the joint's origin instead",
            field=field,
        )
    return SharedMotor(names.index(name), names.index(mimic.leader), mimic.multiplier)


def _same(one: SharedMotor, other: SharedMotor) -> bool:
    return (one.joint, one.leader) == (other.joint, other.leader) and (
        abs(one.ratio - other.ratio) < _TOLERANCE
    )

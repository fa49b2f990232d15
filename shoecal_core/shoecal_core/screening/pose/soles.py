"""Soles that are not level while both feet carry load: a joint's zero is far off.

Found before all else that joint angles show, since a foot then looks lifted all the time.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from shoecal_core.arrays import FloatArray
from shoecal_core.recording.run import Run
from shoecal_core.robot.joint_zeros import OpenLoop, open_loop
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.samples.aligned import Aligned
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.verdict import Finding, name_runs
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.vertical import both_carry_load


@dataclass(frozen=True)
class Soles:
    """What is wrong with them.

    Attributes:
        loop: what the joint angles say.
        loaded: both feet are known to carry load meanwhile.
    """

    loop: OpenLoop
    loaded: bool

    @property
    def text(self) -> str:
        """In words."""
        return self.loop.text(loaded=self.loaded)


def pooled(found: Mapping[int, Soles]) -> list[tuple[tuple[int, ...], Soles]]:
    """Runs that the same joints explain, as one, in the order of their first runs."""
    groups: list[tuple[tuple[int, ...], Soles]] = []
    for number, soles in sorted(found.items()):
        for index, (runs, group) in enumerate(groups):
            both = group.loop.with_another(soles.loop)
            if both is not None and group.loaded == soles.loaded:
                groups[index] = ((*runs, number), Soles(both, soles.loaded))
                break
        else:
            groups.append(((number,), soles))
    return groups


def open_soles(
    runs: Mapping[int, Run], aligned: Mapping[int, Aligned], shoe: Shoe, kinematics: Kinematics
) -> dict[int, Soles]:
    """Runs whose soles are not level, by number; those with a base pose, or that hang, are not
    looked at.

    Where no single joint explains it, both feet have to be known to carry load: else one may be in
    the air.
    """
    found, angles = {}, {}
    for number, one in aligned.items():
        run = runs[number]
        if run.info.hanging or (run.info.support is None and run.base_pose is not None):
            continue
        both = both_carry_load(shoe, one.readings)
        loaded = both is not None and bool(both.any())
        angles[number] = one.joint_angles[both] if loaded else one.joint_angles
        loop = open_loop(kinematics, angles[number])
        if loop is not None and (
            loop.named(loaded=loaded) or (loaded and run.info.support is not None)
        ):
            found[number] = Soles(loop, loaded)
    return _with_one_cause(kinematics, found, angles)


def _with_one_cause(
    kinematics: Kinematics, found: dict[int, Soles], angles: Mapping[int, FloatArray]
) -> dict[int, Soles]:
    """Runs with what explains all runs, or else all of those found; as they are where nothing does.

    Args:
        kinematics: of the robot.
        found: soles that are not level, by run.
        angles: (T, m) of all runs, by number [rad].
    """
    loaded = all(soles.loaded for soles in found.values())
    for numbers in dict.fromkeys((tuple(angles), tuple(found))):
        if not found or len(numbers) < 2:
            break
        cause = open_loop(kinematics, *(angles[number] for number in numbers))
        if cause is not None and cause.named(loaded=loaded):
            return {
                number: Soles(soles.loop.by(cause), soles.loaded) for number, soles in found.items()
            }
    return found


def describe_soles(found: Mapping[int, Soles]) -> list[Finding]:
    """Runs whose soles are not level by the joint angles, those of one cause together."""
    return [
        Finding("FAIL", f"{name_runs(runs)}: {soles.text}", Fault.JOINT_ZERO)
        for runs, soles in pooled(found)
    ]

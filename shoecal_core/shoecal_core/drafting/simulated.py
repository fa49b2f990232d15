"""A simulated reality that suits a robot's size."""

from __future__ import annotations

from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot import JointDeflection, Robot
from shoecal_core.shoe.shoe import Shoe

USUAL_KG, USUAL_COM_HEIGHT_M = 5.3, 0.3
"""Of a NAO, and of its CoM above the soles: the default reality is one of this size."""
LARGE_KG = 10.0
"""Robots that are heavier have finer gears and encoders than a NAO's, below."""
ENCODER_RAD = 1e-4
"""16 bits a turn; a NAO's have 12."""
PLAY_RAD = 0.001
LARGE_DEFLECTION = JointDeflection(sag=0.02, play=0.003)
"""What motions of such a robot count on: sag with the servo's own error, play with an encoder's."""
COMPLIANCE = 0.0015
"""rad/(N m) of a gear on a robot as large as a NAO, which has 0.0045 of both."""


USUAL_STRENGTH = 0.2
"""Torque limit of a NAO's leg joint over its weight and the length of its leg."""
MOST_SAG = 0.3
"""rad."""


def small_deflection(strength: float) -> JointDeflection:
    """Of a robot that is not large: gears do not get stiffer by what their motors could bear.

    So at the limit of a motor that is stronger for its robot than a NAO's, a joint sags more.

    Args:
        strength: torque limit of a leg joint over the weight and the length of the leg.
    """
    usual = Robot.deflection
    sag = min(usual.sag * max(1.0, strength / USUAL_STRENGTH), MOST_SAG)
    return JointDeflection(sag=round(sag, 3), play=usual.play)


def reality_text(robot: Robot, shoe: Shoe) -> str:
    """REALITY.yaml: what of the default reality grows with the robot.

    Shares of masses, offsets and spreads stay; forces grow with the weight, and gears get stiffer
    as the torques that bend them grow. Six-axis sensors are ten times stiffer than a shoe's cells,
    and come calibrated by their maker.

    Args:
        robot: shoes on.
        shoe: its sensors.
    """
    weight = robot.mass / USUAL_KG
    height = float(Kinematics(robot).states(robot.posture[None]).com[0, 0, 2])
    torque = weight * height / USUAL_COM_HEIGHT_M
    cells = {
        "stiffness_n_per_m": 1e5 * weight,
        "noise_std_n": 0.01 * weight,
        "noise_std_nm": 0.0005 * torque,
    }
    if all(channel.nominal_gain is None for channel in shoe.channels):
        cells |= {"full_scale_n": 60.0 * weight, "full_scale_nm": 3.0 * torque}
    else:
        half_span = max(channel.highest for channel in shoe.channels)
        cells |= {"full_scale_n": half_span, "full_scale_nm": half_span}
        cells |= {"gain_spread_fraction": 0.05, "offset_std_fraction": 0.001}
        cells["stiffness_n_per_m"] = 1e6 * weight
    lines = [
        f"# Simulated reality of {robot.name}: changes to the default one, of a robot of 5 kg.",
        "# CHECK: play and compliance of the gears, noise and range of the sensors.",
        "format: 1",
        f"name: {robot.name}",
        f"body: {{weight_error_n: {0.19 * weight:.3g}}}",
    ]
    if robot.mass > LARGE_KG:
        lines += [
            "joints:",
            f"  encoder_resolution_rad: {ENCODER_RAD:g}",
            f"  play_rad: {{all: {PLAY_RAD:g}}}",
            f"  compliance_rad_per_nm: {{all: {COMPLIANCE / torque:.3g}}}",
        ]
    lines += ["cells:", *(f"  {name}: {value:.3g}" for name, value in cells.items())]
    return "\n".join(lines) + "\n"

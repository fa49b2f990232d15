"""How hot the motors are, against how hot they may be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def hottest(temperatures: Mapping[str, float]) -> tuple[str, float] | None:
    """The joint with the hottest motor, and its temperature [degC]; None where none is known."""
    if not temperatures:
        return None
    joint = max(temperatures, key=lambda name: temperatures[name])
    return joint, temperatures[joint]


def too_hot(temperatures: Mapping[str, float], limit: float) -> str:
    """Which joint is hotter than a limit [degC]; empty when none is."""
    found = hottest(temperatures)
    if found is None or found[1] < limit:
        return ""
    return f"joint '{found[0]}' is at {found[1]:.0f} degC (limit {limit:g} degC)"


def margin(temperatures: Mapping[str, float], limit: float) -> str:
    """How far the hottest joint is below a limit [degC], in words."""
    found = hottest(temperatures)
    if found is None:
        return "no motor temperatures come: heat is not watched"
    joint, degc = found
    return f"hottest joint '{joint}' at {degc:.0f} degC, {limit - degc:.0f} degC below the limit"


def forecast(
    temperatures: Mapping[str, float],
    joints: Sequence[str],
    load: FloatArray,
    duration: float,
    rise: float,
    time_constant: float,
    ambient: float,
) -> tuple[dict[str, float], dict[str, float]]:
    """Motors after a motion, and after it has been repeated without end, by joint [degC].

    A motor warms up with the square of its torque and cools to what is around it, at first order:

        T' = (ambient + rise * load - T) / time_constant

    Args:
        temperatures: of the motors that tell theirs, now [degC].
        joints: k of them move.
        load: (k,) mean of (torque / limit)^2 over the motion.
        duration: of the motion [s].
        rise: end temperature over the ambient at full torque [K].
        time_constant: of a motor [s].
        ambient: temperature [degC].
    """
    kept = float(np.exp(-duration / time_constant))
    ends = {
        joint: ambient + rise * float(share)
        for joint, share in zip(joints, load, strict=True)
        if joint in temperatures
    }
    after = {joint: end + (temperatures[joint] - end) * kept for joint, end in ends.items()}
    return after, {joint: max(end, after[joint]) for joint, end in ends.items()}

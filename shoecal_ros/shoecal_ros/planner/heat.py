"""How hot the motors are, against how hot they may be."""

from __future__ import annotations

from collections.abc import Mapping


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

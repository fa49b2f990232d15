"""What to do with a result: file, command or service; on pages and terminals alike."""

from __future__ import annotations

FILE = "FILE"
"""Stands for a file whose name a page does not know."""


def after_calibration(verdict: str, file: str = FILE, *, by_robot: bool = False) -> str:
    """How a calibration comes into force; empty where it must not be used.

    Args:
        verdict: of it.
        file: that holds it.
        by_robot: a robot may have made it by itself.
    """
    if verdict == "FAIL":
        return ""
    warned = verdict == "WARN"
    when = "Next, when the reasons are read" if warned else "Next"
    call = f"call the service /shoe/set_calibration with {file}{' and force' * warned}"
    if by_robot:
        has = "call the service /shoe/apply" if warned else "it is in force already"
        call = f"on a robot that calibrated itself {has}; elsewhere {call}"
    recorded = f"GRF and CoP of a recording: shoecal apply SESSION --calibration {file}"
    return f"{when}: {call}. {recorded}"


def after_cells(verdict: str, file: str = FILE) -> str:
    """What follows the single cells of a manual calibration."""
    return "" if verdict == "FAIL" else f"Next: shoecal manual shoe DATA --cells {file} --out OUT"


def after_check(verdict: str, session: str) -> str:
    """What follows a session that is fit for a calibration."""
    if verdict == "FAIL":
        return ""
    return f"Next: shoecal calibrate {session} --out calibration.yaml --report report.html"


def after_plan(first: str) -> str:
    """What follows a plan: `first` is the file of its first motion."""
    return (
        "Next: on the robot the service /shoe/self_calibrate plans and moves by itself; a "
        f"controller of your own plays {first} and the others (time in s, joint angles in rad)."
    )


def after_history(changed: bool) -> str:
    """What follows from a robot's calibrations over time."""
    if changed:
        return (
            "Next: use the latest calibration (service /shoe/set_calibration). Where nothing was "
            "repaired or exchanged, look at cells and plugs of the channels below: "
            "shoecal diagnose SESSION."
        )
    return "Next: nothing to do; the first calibration still holds within its uncertainty."

"""A diagnosis on a terminal."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping

from rich.console import Console
from rich.table import Table

from shoecal_core.cli.many_sessions import Ended
from shoecal_core.cli.prose import say
from shoecal_core.cli.tables import new_table, print_table
from shoecal_core.diagnosis.budget import LEAST_SHARE
from shoecal_core.diagnosis.result import VERDICT_TEXTS, Cause, Diagnosis, Size
from shoecal_core.report.diagnosis.words import finding_text, where_text
from shoecal_core.report.quantities import percent
from shoecal_core.workflows.diagnose import CalibratedGap, Diagnosed

_PLACES = re.compile(r"(\(\d+ of \d+ places)(?:: [^()]*)(?=\))")
"""Counts of places, and which these are: the report and the JSON list them."""
SHOWN = 3
"""Places of the gap that are named."""
SMALL: Mapping[str, tuple[float, str]] = {
    "m": (1e3, "mm"),
    "rad": (1e3, "mrad"),
    "s": (1e3, "ms"),
    "rad/(N m)": (1e3, "mrad/(N m)"),
    "1/s": (1e6, "1e-6/s"),
    "1/N": (1e3, "1e-3/N"),
    "1/N^2": (1e6, "1e-6/N^2"),
}
"""Units of sizes that are given in smaller ones."""


def print_diagnosis(
    diagnosis: Diagnosis, calibrated: CalibratedGap | None, console: Console
) -> None:
    """Verdict, gap, causes, what stays open, and what to do next."""
    for line in _answer(diagnosis):
        say(console, line)
    for line in diagnosis.dissent:
        say(console, f"but: {line}")
    for line in _gap(diagnosis, calibrated):
        say(console, f"  {line}")
    if diagnosis.causes:
        console.print()
        print_table(console, causes_table(diagnosis))
    if len(diagnosis.ambiguity) > 1:
        alike = "; ".join(f"{one.label} {percent(one.probability)}" for one in diagnosis.ambiguity)
        say(console, f"not separable: {alike}")
    if made_of := [one for one in diagnosis.budget if abs(one.cop_share) >= LEAST_SHARE]:
        shares = ", ".join(f"{one.label} {percent(one.cop_share)}" for one in made_of)
        say(console, f"the CoP's gap is made of: {shares}")
    unseen = [_PLACES.sub(r"\1", one) for one in diagnosis.cannot_detect]
    lines = [(f"could not be seen here ({len(unseen)})", "; ".join(unseen))]
    if diagnosis.next_motion is not None:
        motion = diagnosis.next_motion
        lines.append(("next motion", f"{motion.motion}, separates {', '.join(motion.separates)}"))
    lines += [("note", note) for note in diagnosis.notes]
    for name, text in lines:
        if text:
            say(console, f"{name}: {text}")


def causes_table(diagnosis: Diagnosis) -> Table:
    """A line a cause; a component of its size below each other."""
    table = new_table("What explains it" if diagnosis.named else "What was asked for")
    for name, justify in (
        ("cause", "left"), ("probability", "right"), ("size (95 %)", "left"),
        ("gap shrinks by", "right"), ("simulated", "right"), ("hidden CoP (mm)", "right"),
    ):  # fmt: skip
        table.add_column(name, justify=justify)  # type: ignore[arg-type]
    for cause in diagnosis.causes:
        low, high = cause.shrink.ci95
        where = "" if cause.run is None else f", run {cause.run}"
        table.add_row(
            f"{cause.label}{where}",
            percent(cause.probability),
            "\n".join(f"{name} {size_text(size)}" for name, size in cause.size.items()),
            f"{cause.shrink.fraction:.0%} ({low:.0%} to {high:.0%})",
            "-" if cause.simulated is None else f"{cause.simulated.fraction:.0%}",
            f"{cause.hidden_cop_mm:.2f}",
        )
    return table


def _first_cause(one: Ended[Diagnosed], text: Callable[[Cause], str]) -> str:
    named = () if one.found is None else one.found.diagnosis.named
    return text(named[0]) if named else "-"


SESSIONS: Mapping[str, Callable[[Ended[Diagnosed]], str]] = {
    "verdict": lambda one: str(one.figures["verdict"]),
    "gap shrinks by": lambda one: _first_cause(one, lambda first: f"{first.shrink.fraction:.0%}"),
    "first cause": lambda one: _first_cause(one, lambda first: first.label),
}
"""Columns of a table with a line a session."""


def size_text(size: Size) -> str:
    """A component with its interval, for a person."""
    scale, unit = SMALL.get(size.unit, (1.0, size.unit))
    value, low, high = (scale * number for number in (size.value, *size.ci95))
    return f"{value:.3g} ({low:.3g} to {high:.3g}) {unit}".rstrip()


def _answer(diagnosis: Diagnosis) -> Iterator[str]:
    """What to do at which place, then what the verdict means and what the cure is to win."""
    action, won = diagnosis.action, ""
    if action is not None:
        before, after = action.expected_cop_mm
        found = f"{finding_text(diagnosis.named[0])}: " if diagnosis.named else ""
        yield f"{found}{action.do}"
        won = f"; expected CoP error {before:.2f} -> {after:.2f} mm" if after < before else ""
    yield f"{diagnosis.verdict}: {VERDICT_TEXTS[diagnosis.verdict]}{won}"


def _gap(diagnosis: Diagnosis, calibrated: CalibratedGap | None) -> Iterator[str]:
    gap = diagnosis.gap
    runs = ", ".join(map(str, diagnosis.test)) or "none"
    yield (
        f"gap on test runs ({runs}): CoP {gap.cop_mae_mm:.2f} mm (within tolerance "
        f"{gap.cop_floor_mm:.2f}), GRF {gap.grf_mae_n:.3f} N (within tolerance "
        f"{gap.grf_floor_n:.3f})"
    )
    if calibrated is not None:
        yield (
            f"under calibration '{calibrated.id}': CoP {calibrated.cop_mae_mm:.2f} mm, "
            f"GRF {calibrated.grf_mae_n:.3f} N"
        )
    for place in diagnosis.where[:SHOWN]:
        yield f"{percent(place.share)} in {where_text(place)}"

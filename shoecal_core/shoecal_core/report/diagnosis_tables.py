"""The tables of a report on a diagnosis."""

from __future__ import annotations

from collections.abc import Callable

from shoecal_core.diagnosis.result import Diagnosis, Shrink, SimulatedShrink
from shoecal_core.report.diagnosis_answer import (
    interval_text,
    millimetres,
    newtons,
    shrink_text,
    whole_shrink,
)
from shoecal_core.report.diagnosis_words import (
    candidate_text,
    effect_of,
    effect_text,
    label_text,
    listed,
    sizes_text,
    why_alike,
)
from shoecal_core.report.figures.shares import percent
from shoecal_core.report.page import Table
from shoecal_core.report.quantities import UNKNOWN


def causes_table(diagnosis: Diagnosis) -> Table:
    """What was found."""
    return Table(
        "What was found",
        ("effect and place", "that is", "class", "size", "probability"),
        tuple(
            (candidate_text(cause), effect_text(cause.effect), cause.group.replace("_", " "),
             sizes_text(cause) or UNKNOWN, percent(cause.probability))
            for cause in diagnosis.causes
        ),
    )  # fmt: skip


def alike_table(diagnosis: Diagnosis) -> Table | None:
    """Sets that cannot be told apart, and why; None where there are none."""
    sets = list(diagnosis.cannot_separate)
    first = tuple(one.label for one in diagnosis.ambiguity)
    if len(first) > 1 and set(first) not in [set(one) for one in sets]:
        sets.insert(0, first)
    if not sets:
        return None
    return Table(
        "Alike in this session",
        ("these", "because"),
        tuple((listed([label_text(name) for name in one], "or"), why_alike(one)) for one in sets),
        "Told of the motions of this session. What is not found is listed too: if it were "
        "there, it could be taken for its companion.",
    )


def blind_spots_table(diagnosis: Diagnosis) -> Table | None:
    """What could not be detected; None where there is nothing."""
    if not diagnosis.cannot_detect:
        return None
    rows: list[tuple[str, ...]] = []
    for text in diagnosis.cannot_detect:
        what, _, why = text.partition(": ")
        rows.append((label_text(what), effect_text(effect_of(what)), why or UNKNOWN))
    header: tuple[str, ...] = ("it could be there", "that is", "and would not be seen, because")
    if all(why == UNKNOWN for *_, why in rows):
        header, rows = header[:2], [row[:2] for row in rows]
    return Table("Not to be seen in this session", header, tuple(rows))


def shrink_table(diagnosis: Diagnosis) -> Table:
    """How far the gap shrinks, measured and simulated."""
    several = len(diagnosis.causes) > 1
    first = diagnosis.causes[0]
    name = "all of it" if several else candidate_text(first)
    rows = [_shrink_row(f"{name}, measured", whole_shrink(diagnosis))]
    simulated = next((one.simulated for one in diagnosis.causes if one.simulated is not None), None)
    if simulated is not None:
        rows.append(_shrink_row(f"{name}, simulated", simulated))
    if several:
        rows += [
            _shrink_row(f"{candidate_text(cause)}, beside the others", cause.shrink)
            for cause in diagnosis.causes
        ]
    return Table(
        "How far the gap shrinks",
        ("with", "share that is gone", "CoP error", "GRF error"),
        tuple(rows),
        "Share that is gone: of the squared error beyond noise, on test runs."
        + (" Beside the others: from all but this one to all." if several else ""),
    )


def _shrink_row(label: str, shrink: Shrink | SimulatedShrink) -> tuple[str, ...]:
    share = shrink_text(shrink.fraction)
    if isinstance(shrink, Shrink) and interval_text(shrink):
        share += f" ({interval_text(shrink)})"
    return (
        label, share, _from_to(shrink.cop_mae_mm, millimetres), _from_to(shrink.grf_mae_n, newtons),
    )  # fmt: skip


def hidden_table(diagnosis: Diagnosis) -> Table:
    """What a calibration would have swallowed."""
    return Table(
        "Hidden by a calibration",
        ("effect", "CoP error it would absorb"),
        tuple(
            (candidate_text(cause), millimetres(cause.hidden_cop_mm)) for cause in diagnosis.causes
        ),
    )


def notes_table(diagnosis: Diagnosis) -> Table:
    """What was missing, and what was used."""
    runs = (("training runs", listed([str(run) for run in diagnosis.train]) or "none"),
            ("test runs", listed([str(run) for run in diagnosis.test]) or "none"),
            ("robot", diagnosis.robot), ("shoes", diagnosis.shoe))  # fmt: skip
    return Table("What this rests on", ("", ""), runs)


def _from_to(pair: tuple[float, float], shown: Callable[[float], str]) -> str:
    return f"{shown(pair[0])} → {shown(pair[1])}"

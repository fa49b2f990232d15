"""The tables of a report on a diagnosis."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

import numpy as np

from shoecal_core.diagnosis.result import Diagnosis, NamedHypothesis, Shrink, SimulatedShrink
from shoecal_core.error_sources.effects.words import WORDS, name_of, words_of
from shoecal_core.report.diagnosis.answer import (
    interval_text,
    millimetres,
    newtons,
    shrink_text,
    whole_shrink,
)
from shoecal_core.report.diagnosis.figures import hidden_rms_mm
from shoecal_core.report.diagnosis.words import (
    effect_of,
    hypothesis_text,
    label_text,
    listed,
    sizes_text,
    why_alike,
)
from shoecal_core.report.origin import robot_text, shoe_text
from shoecal_core.report.page import Table
from shoecal_core.report.quantities import SPACE, UNKNOWN, percent, size
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import Shoe

MOST_OF_SET = 6
"""Hypotheses of one set that are spelt out."""
MOST_ALIKE = 3
"""Sets alike for one reason that are spelt out."""
_PLACES = re.compile(r"(\w+)((?: of | between )[^(]+)? (\(\d+ of \d+ places.*\))$")


HIDDEN = (
    "Hidden: the CoP error that a calibration absorbs, as it bends gains and offsets until they "
    "imitate an effect that its model lacks."
)

SHARE_GONE = "Share that is gone: of the squared error beyond noise, on the runs judged."
LEAST_SHARE = 0.02
"""Of a gap's mean square, that a source is listed from."""


def causes_table(diagnosis: Diagnosis) -> Table:
    """What was found, and how much of it a calibration would have hidden."""
    note = HIDDEN
    if diagnosis.evidence is not None:
        whole, shown = hidden_rms_mm(diagnosis.evidence)
        if np.isfinite(whole) and np.isfinite(shown):
            note += (
                f" What was found moves the CoP by {size(whole, 'mm')} (RMS); after gains and "
                f"offsets were fitted around it, {size(shown, 'mm')} of it still showed."
            )
    return Table(
        "What was found" if diagnosis.named else "What was asked for",
        ("effect and place", "what it does", "class", "size", "probability", "hidden"),
        tuple(
            (hypothesis_text(cause), words_of(cause.effect).state, name_of(cause.group),
             sizes_text(cause) or UNKNOWN, percent(cause.probability),
             millimetres(cause.hidden_cop_mm))
            for cause in diagnosis.causes
        ),
        note,
    )  # fmt: skip


def budget_table(diagnosis: Diagnosis) -> Table | None:
    """What the CoP's gap is made of; None where that is not known."""
    if not diagnosis.budget:
        return None
    return Table(
        "What the CoP's error is made of",
        ("source and place", "share of its mean square", f"95{SPACE}% interval"),
        tuple(
            (hypothesis_text(NamedHypothesis(one.source, one.location, 0.0)),
             percent(one.cop_share),
             f"{percent(one.ci95[0])} to {percent(one.ci95[1])}")
            for one in diagnosis.budget
            if abs(one.cop_share) >= LEAST_SHARE
        ),
        f"Sources below {LEAST_SHARE:.0%} are left out; a share is negative where it makes up for "
        "another.".replace("%", f"{SPACE}%"),
    )  # fmt: skip


def alike_table(diagnosis: Diagnosis) -> Table | None:
    """Sets that cannot be separated, and why; None where there are none."""
    sets = list(diagnosis.cannot_separate)
    first = tuple(one.label for one in diagnosis.ambiguity)
    if len(first) > 1 and set(first) not in [set(one) for one in sets]:
        sets.insert(0, first)
    if not sets:
        return None
    reasons: dict[str, list[str]] = {}
    for one in sets:
        names = [label_text(name) for name in one]
        if len(names) > MOST_OF_SET:
            names[MOST_OF_SET:] = [f"{len(names) - MOST_OF_SET} more"]
        reasons.setdefault(why_alike(one), []).append(listed(names, "or"))
    return Table(
        "Alike in this session",
        ("these", "because"),
        tuple((_first(alike), why) for why, alike in reasons.items()),
        "For the motions of this session. What is not found is listed too: if it were "
        "there, it could be taken for its companion.",
    )


def _first(names: Sequence[str]) -> str:
    """A few of many, and how many more."""
    shown = "; ".join(names[:MOST_ALIKE])
    return shown if len(names) <= MOST_ALIKE else f"{shown}; and {len(names) - MOST_ALIKE} more"


def blind_spots_table(diagnosis: Diagnosis) -> Table | None:
    """What could not be detected; None where there is nothing."""
    if not diagnosis.cannot_detect:
        return None
    return Table(
        "Not to be seen in this session",
        ("it could be there", "what it does", "where, or why it would not be seen"),
        tuple(_blind_spot(text) for text in diagnosis.cannot_detect),
    )


def _blind_spot(text: str) -> tuple[str, str, str]:
    """What, in words, where or why: of `effect of … (k of n places: …)` or `what: why`."""
    found = _PLACES.match(text)
    if found is not None:
        effect, common, places = found.groups("")
        return (name_of(effect), words_of(effect).state, _where(common.strip(), places))
    what, _, why = text.partition(": ")
    known = WORDS.get(effect_of(what))
    return (label_text(what), known.state if known else UNKNOWN, why or UNKNOWN)


def _where(common: str, places: str) -> str:
    """What places have in common, and which they are; no brackets where nothing stands before."""
    return f"{common} {places}" if common else places[1:-1]


def shrink_table(diagnosis: Diagnosis) -> Table:
    """How far the gap shrinks, measured and simulated."""
    several = len(diagnosis.causes) > 1
    if several and not diagnosis.named:
        return Table(
            "How far the gap shrinks",
            ("with", "share that is gone", "CoP error", "GRF error"),
            tuple(_shrink_row(hypothesis_text(one), one.shrink) for one in diagnosis.causes),
            f"{SHARE_GONE} Each by itself.",
        )
    first = diagnosis.causes[0]
    name = "all of it" if several else hypothesis_text(first)
    rows = [_shrink_row(f"{name}, measured", whole_shrink(diagnosis))]
    simulated = next((one.simulated for one in diagnosis.causes if one.simulated is not None), None)
    if simulated is not None:
        rows.append(_shrink_row(f"{name}, simulated", simulated))
    if several:
        rows += [
            _shrink_row(f"{hypothesis_text(cause)}, with the others", cause.shrink)
            for cause in diagnosis.causes
        ]
    return Table(
        "How far the gap shrinks",
        ("with", "share that is gone", "CoP error", "GRF error"),
        tuple(rows),
        SHARE_GONE + (" With the others: from all but this one to all." if several else ""),
    )


def _shrink_row(label: str, shrink: Shrink | SimulatedShrink) -> tuple[str, ...]:
    share = shrink_text(shrink.fraction)
    if isinstance(shrink, Shrink) and interval_text(shrink):
        share += f" ({interval_text(shrink)})"
    return (
        label, share, _from_to(shrink.cop_mae_mm, millimetres), _from_to(shrink.grf_mae_n, newtons),
    )  # fmt: skip


def notes_table(diagnosis: Diagnosis, robot: Robot, shoe: Shoe) -> Table:
    """What was missing, and what was used."""
    runs = (("training runs", listed([str(run) for run in diagnosis.train]) or "none"),
            ("test runs", listed([str(run) for run in diagnosis.test]) or "none"),
            ("robot", robot_text(robot)), ("shoes", shoe_text(shoe)))  # fmt: skip
    return Table("What this rests on", ("", ""), runs)


def _from_to(pair: tuple[float, float], shown: Callable[[float], str]) -> str:
    return f"{shown(pair[0])} → {shown(pair[1])}"

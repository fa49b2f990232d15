"""A robot built worse than its tolerances say: what looks like an unknown cause may be that.

What tolerance errors add in another form than the library has them in is then larger than usual, in
the signals that depend on gears and links; no gear changes the weight. As a hypothesis it costs
what its levels cost (`scoring`), and holds when neither a cause nor an unmodelled term is evident
next to it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from shoecal_core.diagnosis.answer import Answer, answer, first_confirmed
from shoecal_core.diagnosis.result import Cause
from shoecal_core.diagnosis.scoring import Scored
from shoecal_core.diagnosis.selection import Selection
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.signals import COP


def answer_as_built(
    searched: Workspace,
    certain: Sequence[Cause],
    found: Selection,
    settings: DiagnosisSettings,
) -> tuple[Workspace, Answer, tuple[str, ...]]:
    """The verdict; where it were `unknown` and wider tolerances suffice, that there is no gap.

    Args:
        searched: what causes were searched in.
        certain: causes that no fit was needed for.
        found: what test runs confirm.

    Returns:
        With tolerance errors as the answer has them, the answer, and in words how much wider.
    """
    best = searched.at(found.stands(searched.scorer, settings))
    said = answer(best, certain, found, settings)
    if said.verdict != "unknown":
        return best, said, ()
    wide = searched.built_worse()
    factor = times_usual(wide.built)
    rest, _ = first_confirmed(wide, settings)
    suffices = rest.chosen is None and answer(wide, (), rest, settings).verdict == "no_gap"
    if factor <= 1.0 or not suffices:
        return best, said, ()
    note = (
        "the robot is built worse than its tolerances say: gears and plates move the CoP "
        f"{factor:g} times as far as usual in ways that the model does not have: have them "
        "repaired, or declare wider tolerances"
    )
    return wide, replace(said, verdict="no_gap"), (note,)


def times_usual(scored: Scored) -> float:
    """Of what tolerance errors add to the CoP in another form, over the usual."""
    here = np.isin(scored.scorer.rows.signal, np.r_[COP])
    return float(scored.form_level[here].max(initial=0.0))

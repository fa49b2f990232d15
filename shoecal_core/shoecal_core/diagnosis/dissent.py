"""What speaks against an explanation lowers its claim, in number and in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from shoecal_core.diagnosis.action import action
from shoecal_core.diagnosis.result import Diagnosis, Gap
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.shrink import maes
from shoecal_core.diagnosis.workspace import Workspace

FloatArray = NDArray[np.float64]
WORSE = 1.1
"""Errors of a test run that grow by more than this factor speak against an explanation."""
REPLAYED_FROM = 1.0 / 3.0
"""Part of what a cause removes in the model that its replay has to remove."""
CLEAR = 2.0
"""Gap over its floor, squared, from which a replay can confirm or deny anything: two robots of one
kind share their weight between feet and cells a little otherwise, which is of the floor's size."""


def worse_runs(
    workspace: Workspace, before: FloatArray, after: FloatArray, settings: DiagnosisSettings
) -> tuple[tuple[int, ...], tuple[str, ...]]:
    """Test runs whose errors of CoP or GRF grow with an explanation, and that in words.

    Args:
        before, after: (T, s) residuals without it and with it.
    """
    least_n = workspace.signal_model.samples.robot.weight * settings.material_share
    runs, reasons = [], []
    for run in workspace.test:
        (cop, grf), (cop_after, grf_after) = (
            maes(workspace, one, [run]) for one in (before, after)
        )
        grown = []
        if cop_after > max(WORSE * cop, cop + settings.material_m):
            grown.append(f"CoP {1e3 * cop:.2f} -> {1e3 * cop_after:.2f} mm")
        if grf_after > max(WORSE * grf, grf + least_n):
            grown.append(f"GRF {grf:.3f} -> {grf_after:.3f} N")
        if grown:
            runs.append(run)
            reasons.append(f"test run {run} gets worse with it: {', '.join(grown)}")
    return tuple(runs), tuple(reasons)


def lowered(diagnosis: Diagnosis, worse: Sequence[int]) -> Diagnosis:
    """With test runs that get worse: each takes half its share of the probability.

    A run in which it fits badly speaks half against a cause, as one may be right and its size a
    little off; shares are counted by the rule of succession, as of few runs none is all. What
    happened in one run that was fitted is not judged by others.
    """
    if not worse:
        return diagnosis
    share = (len(diagnosis.test) - 0.5 * len(worse) + 1.0) / (len(diagnosis.test) + 1.0)
    causes = tuple(
        cause if cause.run is not None else replace(cause, probability=share * cause.probability)
        for cause in diagnosis.causes
    )
    verdict = diagnosis.verdict
    return replace(
        diagnosis, causes=causes, verdict="partly_explained" if verdict == "explained" else verdict
    )


def after_replay(diagnosis: Diagnosis) -> Diagnosis:
    """Without causes that the simulator does not confirm: there they remove hardly anything.

    What happened in one run that was fitted is not in the runs that are replayed.
    """
    denied = [
        cause
        for cause in diagnosis.causes
        if cause.simulated is not None
        and (cause.run is None or cause.run in diagnosis.test)
        and cause.simulated.fraction < REPLAYED_FROM * cause.simulated.claimed
    ]
    if not denied or not _clear(diagnosis.gap):
        return diagnosis
    left = tuple(cause for cause in diagnosis.causes if cause not in denied)
    simulated = denied[0].simulated
    assert simulated is not None
    names = " and ".join(cause.label for cause in denied)
    words = (
        f"{names}: replayed in the simulator it removes {simulated.fraction:.0%} of the "
        f"difference, where it should remove {simulated.claimed:.0%}: not named"
    )
    evidence = diagnosis.evidence
    found = replace(
        diagnosis,
        causes=left,
        verdict="partly_explained" if left else "unknown",
        ambiguity=diagnosis.ambiguity if left else (),
        next_motion=diagnosis.next_motion if left else None,
        shrink=diagnosis.shrink if left else None,
        dissent=(*diagnosis.dissent, words),
        evidence=evidence if left or evidence is None else replace(evidence, explained=None),
    )
    return replace(found, action=action(found))


def _clear(size: Gap) -> bool:
    """Whether CoP or GRF are off by clearly more than a robot as built."""
    cop, grf = size.cop_mae_mm / size.cop_floor_mm, size.grf_mae_n / size.grf_floor_n
    return max(cop, grf) ** 2 > CLEAR

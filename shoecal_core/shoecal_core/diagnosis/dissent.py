"""What speaks against an explanation lowers its claim, in number and in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from shoecal_core.arrays import FloatArray
from shoecal_core.diagnosis.result import Diagnosis
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.shrink import maes
from shoecal_core.diagnosis.workspace import Workspace

WORSE = 1.1
"""Errors of a test run that grow by more than this factor speak against an explanation."""


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


def less_probable(diagnosis: Diagnosis, worse: Sequence[int]) -> Diagnosis:
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

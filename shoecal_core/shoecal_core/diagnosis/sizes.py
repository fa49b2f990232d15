"""How large what was found is, with intervals that hold whatever form reality has it in."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from shoecal_core.diagnosis.result import Size
from shoecal_core.diagnosis.scoring import Scored
from shoecal_core.diagnosis.tempering import shares
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.base import Component, split_name
from shoecal_core.error_sources.deviation import FORM

Z95 = 1.96


def sizes(workspace: Workspace, scored: Scored, index: int) -> Mapping[str, Size]:
    """Of one part, by component."""
    hypothesis, form = scored.parts[index]
    known = {component.name: component for component in hypothesis.effect.components}
    own = scored.own(index)
    values = scored.vector[own]
    deviations = np.sqrt(np.diag(scored.covariance)[own])
    # Another form of an effect moves its components together, each as far as it usually goes.
    whole = float(np.linalg.norm(values / form.std))
    found: dict[str, Size] = {}
    for name, value, deviation, std in zip(
        form.shape.free, values, deviations, form.std, strict=True
    ):
        component = known.get(split_name(name)[0])
        if component is not None:
            found[name] = _size(component, float(value), deviation, FORM * std * whole)
    for name, value in form.shape.fixed.items():
        if name in known:
            deviation = form_spread(workspace, scored, index, name, value)
            found[name] = _size(known[name], value, deviation, FORM * value)
    return found


def _size(component: Component, value: float, deviation: float, form_error: float) -> Size:
    """With its interval.

    Args:
        deviation: standard one by the data. form_error: the same of an effect's usual form.
    """
    spread = Z95 * float(np.linalg.norm((deviation, component.form * form_error, component.blur)))
    return Size(value, component.unit, (value - spread, value + spread))


def form_spread(workspace: Workspace, scored: Scored, index: int, name: str, value: float) -> float:
    """How far a component that forms hold may be off: as the evidence of the other forms says."""
    hypothesis, _ = scored.parts[index]
    others = [part for at, part in enumerate(scored.parts) if at != index]
    found = [
        (
            form.shape.fixed.get(name, value),
            workspace.scorer.score([*others, (hypothesis, form)]).evidence,
        )
        for form in hypothesis.forms
    ]
    values = np.array([one for one, _ in found])
    evidence = np.array([one for _, one in found])
    share = shares(evidence)
    step = np.diff(np.unique(values))
    grid = 0.5 * float(step.min()) if len(step) else 0.5 * abs(value)
    return float(np.hypot(np.sqrt(share @ (values - value) ** 2), grid / np.sqrt(3.0)))

"""Explanations fitted to a session in which one of them is true by construction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from shoecal_core.diagnosis.scoring import Scored, Scorer
from shoecal_core.diagnosis.workspace import Workspace


def where(
    workspace: Workspace, true: str, size: Sequence[float], *others: str
) -> tuple[Workspace, list[tuple[Scored, float]]]:
    """A session whose residuals are what an effect adds, and noise; and the rivals' fits to it.

    Args:
        true, others: labels; all are equally probable.
        size: of the true one's components, in its middle form.
    """
    known = {hypothesis.label: hypothesis for hypothesis in workspace.catalogue.hypotheses}
    forms = known[true].forms
    sums = workspace.sums
    own = sums.base + np.array(forms[len(forms) // 2].columns)
    products = sums.products.copy()
    for one, rows in zip(products, sums.rows, strict=True):
        one[-1, :-1] = one[:-1, -1] = np.asarray(size) @ one[own, :-1]
        one[-1, -1] = np.asarray(size) @ one[np.ix_(own, own)] @ np.asarray(size) + rows
    sums = replace(sums, products=products)
    scorer = Scorer(sums, workspace.train)
    labels = (true, *others)
    fits = [(scorer.best_form(known[label]), 1.0 / len(labels)) for label in labels]
    return replace(workspace, sums=sums, scorer=scorer), fits

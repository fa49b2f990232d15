"""Sessions drawn from the diagnosis' own statistics: true effects of known size, and noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.fft import idct

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.diagnosis.hypotheses import Hypothesis
from shoecal_core.diagnosis.scoring import Part, Scorer
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.whitening import WhitenedProducts, make_sums

MADE = 0.3
"""Times the tolerances that a drawn robot is as built."""


def coloured(workspace: Workspace, rng: np.random.Generator) -> FloatArray:
    """(T, s) of noise that has the workspace's variance in every band."""
    spectrum = workspace.whitening.spectrum
    std = np.sqrt(workspace.noise.ravel()[spectrum.group])
    drawn = np.where(spectrum.kept, std * rng.normal(size=std.shape), 0.0)
    found = np.zeros_like(drawn)
    for rows, own in spectrum.parts:
        part = np.ix_(rows, own)
        found[part] = idct(drawn[part], axis=0, norm="ortho")
    return np.where(workspace.signal_model.mask, found, 0.0)


def hypothesis(workspace: Workspace, label: str) -> Hypothesis:
    """By its label."""
    return {one.label: one for one in workspace.catalogue.hypotheses}[label]


def part(workspace: Workspace, label: str) -> Part:
    """A hypothesis with its middle form."""
    found = hypothesis(workspace, label)
    return found, found.usual


@dataclass(frozen=True)
class Urn:
    """Draws sessions of one layout.

    Attributes:
        workspace: the layout.
        whitened: (q, R) of all columns, on the training runs.
        kept: (T, s) which coefficients these are.
    """

    workspace: Workspace
    whitened: FloatArray
    kept: BoolArray

    @classmethod
    def of(cls, workspace: Workspace) -> Urn:
        """Whiten all columns once."""
        whole = np.concatenate((workspace.signal_model.baseline, workspace.catalogue.columns))
        kept = workspace.whitening.kept & workspace.rows_of(workspace.train)[:, None]
        return cls(workspace, workspace.whitening(whole)[:, kept], kept)

    def draw(
        self, rng: np.random.Generator, truth: Mapping[str, Sequence[float]] | None = None
    ) -> Workspace:
        """Noise, errors as built, and at each stance one of its own; the truth adds by label."""
        workspace = self.workspace
        residuals = coloured(workspace, rng)
        for one in workspace.signal_model.nuisances:
            std = MADE * one.std if one.as_built else one.std
            residuals += one.column * rng.normal() * (std if std < 1.0 else 0.0)
        for label, size in (truth or {}).items():
            _, form = part(workspace, label)
            residuals += np.tensordot(size, workspace.catalogue.columns[list(form.columns)], 1)
        return self.showing(residuals)

    def showing(self, residuals: FloatArray) -> Workspace:
        """The layout with these residuals (T, s)."""
        workspace = self.workspace
        signal_model = replace(workspace.signal_model)
        # All else that the signal model has worked out stays.
        signal_model.__dict__.update(workspace.signal_model.__dict__ | {"residuals": residuals})
        own = workspace.whitening(residuals)[self.kept]
        products = workspace.sums.products.copy()
        products[:-1, -1] = products[-1, :-1] = self.whitened @ own
        products[-1, -1] = own @ own
        old = workspace.scorer
        told = workspace.whitening.spectrum(residuals)
        none = np.zeros_like(old.rows.away)
        others = workspace.whitening.kept & workspace.rows_of(workspace.test)[:, None]
        assert old.withheld is not None
        withheld = replace(old.withheld, residuals=told[others], away=none)
        rows = replace(old.rows, residuals=told[self.kept], away=none)
        scorer = Scorer(rows, old.channels, withheld)
        sums = replace(workspace.sums, products=products)
        return replace(
            workspace,
            signal_model=signal_model,
            sums=sums,
            scorer=scorer,
            built=scorer.nothing,
        )


def remade(workspace: Workspace, runs: Sequence[int] = ()) -> WhitenedProducts:
    """Sums from nothing but the workspace's signal_model, of other runs if any are named."""
    signal_model = workspace.signal_model
    return make_sums(
        workspace.whitening,
        runs or workspace.train,
        signal_model.baseline,
        workspace.catalogue.columns,
        signal_model.residuals,
        workspace.sums.precision,
    )

"""Sessions drawn from the diagnosis' own statistics: true effects of known size, and noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from shoecal_core.diagnosis.hypotheses import Hypothesis
from shoecal_core.diagnosis.scoring import Part, Scorer
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.regression import Noise, make_sums

FloatArray = NDArray[np.float64]


def correlated(noise: Noise, workspace: Workspace, rng: np.random.Generator) -> FloatArray:
    """(T, s) of noise that begins anew in each segment."""
    segment = workspace.scene.samples.segment
    white = rng.normal(size=(len(segment), len(noise.std)))
    found = noise.std * white
    for index in range(1, len(segment)):
        if segment[index] == segment[index - 1]:
            found[index] = noise.keep * found[index - 1] + noise.innovation * white[index]
    return np.where(workspace.scene.mask, found, 0.0)


def hypothesis(workspace: Workspace, label: str) -> Hypothesis:
    """By its label."""
    return {one.label: one for one in workspace.catalogue.hypotheses}[label]


def part(workspace: Workspace, label: str) -> Part:
    """A hypothesis with its middle form."""
    found = hypothesis(workspace, label)
    return found, found.foreseen[len(found.foreseen) // 2]


@dataclass(frozen=True)
class Urn:
    """Draws sessions of one layout.

    Attributes:
        workspace: the layout.
        whitened: (q, T, s) of all columns.
    """

    workspace: Workspace
    whitened: FloatArray

    @classmethod
    def of(cls, workspace: Workspace) -> Urn:
        """Whiten all columns once."""
        whole = np.concatenate((workspace.scene.baseline, workspace.catalogue.columns))
        return cls(workspace, workspace.whitening(whole))

    def draw(
        self, rng: np.random.Generator, truth: Mapping[str, Sequence[float]] | None = None
    ) -> Workspace:
        """Noise and, at each stance, an error of its own; the truth adds to it by label."""
        workspace = self.workspace
        residuals = correlated(workspace.noise, workspace, rng)
        for column, std in workspace.scene.nuisances:
            residuals += column * rng.normal() * (std if std < 1.0 else 0.0)
        for label, size in (truth or {}).items():
            _, form = part(workspace, label)
            residuals += np.tensordot(size, workspace.catalogue.columns[list(form.columns)], 1)
        return self.showing(residuals)

    def showing(self, residuals: FloatArray) -> Workspace:
        """The layout with these residuals (T, s)."""
        workspace = self.workspace
        scene = replace(workspace.scene)
        # All else that the scene has worked out stays.
        scene.__dict__.update(workspace.scene.__dict__ | {"residuals": residuals})
        rest = workspace.whitening(residuals)
        products = workspace.sums.products.copy()
        for at, run in enumerate(workspace.sums.runs):
            here = workspace.scene.samples.run == run
            mask = workspace.scene.mask[here]
            own = rest[here][mask]
            pulls = self.whitened[:, here][:, mask] @ own
            products[at, :-1, -1] = products[at, -1, :-1] = pulls
            products[at, -1, -1] = own @ own
        sums = replace(workspace.sums, products=products)
        return replace(workspace, scene=scene, sums=sums, scorer=Scorer(sums, workspace.train))


def remade(workspace: Workspace) -> FloatArray:
    """(B, q, q) products from nothing but the workspace's scene."""
    scene = workspace.scene
    return make_sums(
        workspace.whitening,
        [*workspace.train, *workspace.test],
        scene.baseline,
        workspace.catalogue.columns,
        scene.residuals,
        scene.mask,
        workspace.sums.precision,
    ).products

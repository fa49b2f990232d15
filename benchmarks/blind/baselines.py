"""Two usual ways to name a cause, for comparison: a parameter fit with BIC, and forward F-tests.

Both fit the size of an effect of the library together with gains and offsets to all signals of the
training runs, by ordinary least squares with white residuals. They share the library's first-order
predictions with the diagnosis and nothing else: no priors, no noise floor, no runs left out.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.stats import f as f_distribution

from blind.regression import Candidate, Regression, make_regression
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShoecalError

LEVEL = 0.01
"""Of an F-test, over the number of hypotheses."""
MOST_CAUSES = 6
"""That F-tests name: with white residuals there is no end to them."""
SHOWN = 20
"""Hypotheses that a ranking lists."""
_NOTHING = 1e-9
"""Share of a column's square that is left of one that others span."""


class Search:
    """Residuals and candidates without what has been fitted so far."""

    def __init__(self, regression: Regression) -> None:
        self._candidates = regression.candidates
        self._columns = np.hstack([one.columns for one in regression.candidates])
        self._whole = (self._columns**2).sum(axis=0)
        ends = np.cumsum([one.columns.shape[1] for one in regression.candidates])
        self._parts = [
            slice(end - one.columns.shape[1], end)
            for end, one in zip(ends.tolist(), regression.candidates, strict=True)
        ]
        self._left = regression.residuals
        self.fitted = 0
        self._remove(regression.base)

    @property
    def count(self) -> int:
        """Residuals."""
        return len(self._left)

    @property
    def squares(self) -> float:
        """That are left."""
        return float(self._left @ self._left)

    def gains(self) -> FloatArray:
        """(C,) squares that each candidate would take away; none where its size makes no sense."""
        pairs = zip(self._candidates, self._parts, strict=True)
        return np.array([self._gain(part, one.least) for one, part in pairs])

    def _gain(self, part: slice, least: FloatArray) -> float:
        columns = self._columns[:, part]
        own = (columns**2).sum(axis=0) > _NOTHING * self._whole[part]
        columns, least = columns[:, own], least[own]
        moments = columns.T @ self._left
        sizes = np.linalg.pinv(columns.T @ columns, rcond=_NOTHING, hermitian=True) @ moments
        return float(sizes @ moments) if (sizes >= least).all() else 0.0

    def add(self, index: int) -> None:
        """Fit a candidate, too."""
        self._remove(self._columns[:, self._parts[index]])

    def _remove(self, columns: FloatArray) -> None:
        basis = _basis(columns)
        self._left = self._left - basis @ (basis.T @ self._left)
        self._columns = self._columns - basis @ (basis.T @ self._columns)
        self.fitted += basis.shape[1]


def _basis(columns: FloatArray) -> FloatArray:
    left, sizes, _ = np.linalg.svd(
        columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300), full_matrices=False
    )
    return np.asarray(left[:, sizes > np.sqrt(_NOTHING)])


def by_bic(regression: Regression) -> dict[str, object]:
    """The candidate of the least R log(squares / R) + parameters log R, if less than without any.

    What gains and offsets take is the same for all and left out of the parameters.
    """
    search, candidates = Search(regression), regression.candidates
    count, before = search.count, search.squares
    gained = -count * np.log1p(-search.gains() / before)
    criterion = np.array([one.parameters for one in candidates]) * np.log(count) - gained
    weight = np.exp(-0.5 * (criterion - min(0.0, criterion.min())))
    weight /= weight.sum() + np.exp(0.5 * min(0.0, criterion.min()))
    order = [int(index) for index in np.argsort(criterion)]
    chosen = order[:1] if criterion[order[0]] < 0.0 else []
    return _answer(candidates, chosen, order, weight)


def by_f_tests(regression: Regression) -> dict[str, object]:
    """Add the most significant candidate as long as it is significant among all places."""
    search, candidates = Search(regression), regression.candidates
    parameters = np.array([one.parameters for one in candidates])
    hypotheses = len({(one.effect.identifier, one.place) for one in candidates})
    chosen: list[int] = []
    first: list[int] = []
    probability = np.zeros(len(candidates))
    while len(chosen) < MOST_CAUSES:
        gains, free = search.gains(), search.count - search.fitted - parameters
        ratio = (gains / parameters) / ((search.squares - gains) / free)
        chance: FloatArray = np.asarray(f_distribution.logsf(ratio, parameters, free))
        # Beyond what numbers hold, the larger ratio is the less likely one.
        order = np.lexsort((-ratio, chance)).tolist()
        first = first or order
        level = chance[order[0]] + np.log(hypotheses)
        if level >= np.log(LEVEL):
            break
        probability[order[0]] = -np.expm1(min(0.0, level))
        chosen.append(order[0])
        search.add(order[0])
    return _answer(candidates, chosen, [*chosen, *first], probability)


def _answer(
    candidates: Sequence[Candidate], chosen: list[int], order: list[int], weight: FloatArray
) -> dict[str, object]:
    """As `shoecal diagnose --json` has it, as far as it is scored."""

    def listed(indices: list[int]) -> list[dict[str, object]]:
        places: dict[tuple[str, tuple[str, ...]], int] = {}
        for index in indices:
            one = candidates[index]
            places.setdefault((one.effect.identifier, one.place), index)
        return [
            {
                "effect": effect, "class": candidates[index].effect.group,
                "location": list(place), "probability": float(weight[index]), "size": {},
            }
            for (effect, place), index in places.items()
        ]  # fmt: skip

    return {
        "format": 1,
        "verdict": "explained" if chosen else "no_gap",
        "where": [],
        "causes": listed(chosen),
        "ambiguity_set": listed(chosen[:1]),
        "ranking": listed(order)[:SHOWN],
    }


BASELINES = {"BIC": by_bic, "F-tests": by_f_tests}
"""By name."""


def baselines(folder: Path) -> dict[str, bytes]:
    """What each says of a session, or why it says nothing, as JSON."""
    try:
        regression = make_regression(folder)
    except ShoecalError as error:
        return dict.fromkeys(BASELINES, json.dumps({"error": str(error)}).encode())
    return {name: json.dumps(way(regression)).encode() for name, way in BASELINES.items()}

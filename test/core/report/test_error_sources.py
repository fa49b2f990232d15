"""Parts of the expected error, and what knowing a tolerance would win."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shoecal_core.report.error_sources import Cause, ErrorSources, error_sources, sizes

from shoecal_core.calibration.pipeline import Outcome
from shoecal_core.error_sources.tolerances import ModelTolerances, Tolerances
from shoecal_core.estimation.expected import ErrorModel


@pytest.fixture(scope="module")
def model(outcome: Outcome) -> ModelTolerances:
    return ModelTolerances(outcome.data.robot, outcome.data.shoe, Tolerances())


@pytest.fixture(scope="module")
def sources(outcome: Outcome, model: ModelTolerances) -> ErrorSources:
    return error_sources(outcome.assessment, outcome.stages.parameters, model)


def test_parts_make_the_whole(outcome: Outcome, sources: ErrorSources) -> None:
    found = outcome.assessment
    np.testing.assert_allclose(sources.total, sizes((found.both, *found.feet)))
    squares = sources.noise**2 + sources.model**2 + sources.prior**2
    np.testing.assert_allclose(np.sqrt(squares), sources.total, rtol=1e-9)


def test_knowing_more_never_costs(sources: ErrorSources) -> None:
    assert len(sources.causes) == 6
    saved = [sources.saved(cause) for cause in sources.causes]
    assert saved == sorted(saved, reverse=True)
    assert saved[-1] > 0.0
    for cause in sources.causes:
        assert (cause.without <= sources.total * (1.0 + 1e-9)).all()


def test_no_tolerance_that_is_not_named_costs_more(
    outcome: Outcome, model: ModelTolerances, sources: ErrorSources
) -> None:
    """Every tenth of the many is looked at, at every place."""
    found = outcome.assessment.uncertainty
    named = {cause.name for cause in sources.causes}
    least = sources.saved(sources.causes[-1])
    for index in range(0, len(found.causes), 10):
        if found.causes[index] in named:
            continue
        column = found.agreed[:, index]
        known = replace(found, agreed=found.agreed - np.outer(column, column) / column[index])
        spreads = ErrorModel(outcome.stages.parameters, known, model).over_polygons()
        assert sources.saved(Cause(found.causes[index], sizes(spreads))) < 1.1 * least


def test_without_tolerances_only_noise_and_prior(outcome: Outcome, model: ModelTolerances) -> None:
    found = outcome.assessment
    size = len(found.uncertainty.noise)
    bare = replace(
        found.uncertainty, model=np.zeros((size, size)), causes=(), slopes=np.zeros((size, 0)),
        agreed=np.zeros((0, 0)), placing=np.zeros((3, 0)),
    )  # fmt: skip
    sources = error_sources(replace(found, uncertainty=bare), outcome.stages.parameters, model)
    assert sources.causes == ()


def test_the_base_is_called_what_it_is() -> None:
    assert Cause("CoM of root_joint along y", np.zeros(3)).text == "CoM of the base link along y"
    assert Cause("zero of LKneePitch", np.zeros(3)).text == "zero of LKneePitch"

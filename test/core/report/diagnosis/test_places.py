from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.report import diagnoses
from core.shoe import shoes
from shoecal_core.diagnosis.result import Evidence, Fitted
from shoecal_core.report.diagnosis.places import (
    CELL_M,
    accounted_for,
    cop_residual,
    field_of,
    in_sole,
    mean_field,
    signal,
    stands,
)
from shoecal_core.robot.double_support import DoubleSupport


@pytest.fixture(scope="module")
def evidence() -> Evidence:
    return diagnoses.evidence()


def test_one_force_explains_a_wrong_cell_where_that_cell_is(evidence: Evidence) -> None:
    # One cell shows a newton too much, nothing else is wrong, nothing was fitted.
    shoe = shoes.shoe("nao_shoe")
    for name in ("left/rear_right", "right/front_left"):
        index = shoe.names.index(name)
        extra = np.zeros_like(evidence.outputs)
        extra[:, index] = 5.0
        exact = diagnoses.told_in_stance(
            diagnoses.signals_of(shoe, extra, diagnoses.in_left(evidence), evidence.support),
            evidence,
        )
        # G in c + G e_C / e_F is the force that was there.
        forces = np.tile([diagnoses.WEIGHT / 2.0, diagnoses.WEIGHT / 2.0], (len(exact), 1))
        wrong = replace(
            evidence,
            without=Fitted("one cell", exact, np.zeros_like(exact)),
            foot_force=forces,
        )
        foot = int(shoe.foot[index])
        place = shoe.positions[index]
        cells = shoe.positions[shoe.of_foot(foot)]
        told = [accounted_for(wrong, wrong.without, foot, other) for other in cells]
        assert accounted_for(wrong, wrong.without, foot, place) > 0.99
        assert sum(share > 0.99 for share in told) == 1


def test_what_is_lost_in_noise_no_force_explains(evidence: Evidence) -> None:
    quiet = Fitted("", 0.1 * evidence.noise * np.ones_like(evidence.without.residuals),
                   np.zeros_like(evidence.without.residuals))  # fmt: skip
    assert np.isnan(accounted_for(evidence, quiet, 0, np.zeros(2)))


def test_from_the_frame_of_the_stance_to_either_sole(evidence: Evidence) -> None:
    hanging = ~evidence.loaded[:, 0]
    assert hanging.any()
    left = in_sole(evidence, evidence.cop, 0, vectors=False)
    right = in_sole(evidence, evidence.cop, 1, vectors=False)
    np.testing.assert_array_equal(left[~hanging], evidence.cop[~hanging])
    np.testing.assert_array_equal(right[hanging], evidence.cop[hanging])
    for run in np.unique(evidence.run):
        rows = evidence.run == run
        support = DoubleSupport(*map(float, evidence.support[rows][0]))
        assert stands(evidence, int(run)) == support
        np.testing.assert_allclose(support.right_to_left(right[rows]), left[rows], atol=1e-12)
    residual = cop_residual(evidence, evidence.without)
    turned = in_sole(evidence, residual, 1, vectors=True)
    np.testing.assert_allclose(np.linalg.norm(turned, axis=1), np.linalg.norm(residual, axis=1))


def test_without_a_support_the_other_foot_is_not_known(evidence: Evidence) -> None:
    blind = replace(evidence, support=np.full_like(evidence.support, np.nan))
    assert stands(blind, 1) is None
    assert np.isnan(in_sole(blind, blind.cop, 1, vectors=False)[blind.loaded[:, 0]]).all()
    assert len(field_of(blind, blind.without).places)


def test_a_field_is_the_mean_of_its_squares() -> None:
    rng = np.random.default_rng(2)
    inside = np.array([3.5, -2.5]) * CELL_M + rng.uniform(-0.4, 0.4, (20, 2)) * CELL_M
    arrows, force = rng.normal(size=(20, 2)), rng.normal(size=20)
    places = np.vstack((inside, [[1.0, 1.0]], [[np.nan, 0.0]]))
    found = mean_field(places, np.vstack((arrows, np.ones((2, 2)))), np.append(force, [1.0, 1.0]))
    np.testing.assert_allclose(found.places, [inside.mean(axis=0)])
    np.testing.assert_allclose(found.arrows, [arrows.mean(axis=0)])
    np.testing.assert_allclose(found.force, [force.mean()])
    nothing = mean_field(np.full((3, 2), np.nan), np.zeros((3, 2)), np.zeros(3))
    assert not len(nothing.places)


def test_signals_that_are_not_there(evidence: Evidence) -> None:
    assert np.isnan(signal(evidence, evidence.without, "tilt_x")).all()
    silent = evidence.without.residuals.copy()
    silent[:, 0] = 0.0
    assert np.isnan(signal(evidence, replace(evidence.without, residuals=silent), "grf")).all()

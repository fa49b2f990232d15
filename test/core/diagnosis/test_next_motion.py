"""The run that separates what is confused."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

from core.diagnosis import rivals
from shoecal_core.diagnosis.candidates import WARM
from shoecal_core.diagnosis.forecast import PossibleRun
from shoecal_core.diagnosis.next_motion import (
    Fit,
    Separation,
    chosen,
    expected_gain,
    propose,
    separations,
)
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.effects.contact import TURNED

FloatArray = NDArray[np.float64]
SETTINGS = DiagnosisSettings()


def told(
    workspace: Workspace,
    runs: tuple[PossibleRun, ...],
    names: Sequence[str],
    true: tuple[str, Sequence[float]],
    *others: str,
) -> dict[str, FloatArray]:
    """Expected gains in some of the runs that could be next."""
    session, fits = rivals.where(workspace, *true, *others)
    some = [run for run in runs if run.name in names]
    return {one.motion: one.gains for one in separations(session, fits, some, SETTINGS)}


@pytest.mark.parametrize("seed", range(5))
def test_the_gain_is_what_a_new_fit_to_all_runs_leaves(seed: int) -> None:
    """Least squares of both rivals to the recorded rows, then to both sets of rows."""
    rng = np.random.default_rng(seed)
    recorded, new = rng.normal(size=(40, 6)), rng.normal(size=(15, 6))
    prior = rng.uniform(0.1, 2.0, 6)
    measured = recorded @ rng.normal(size=6) + rng.normal(size=40)
    used = {"a": np.array([0, 1, 2, 3]), "b": np.array([0, 1, 4, 5])}

    def fit(rows: FloatArray, values: FloatArray, own: NDArray[np.int64]) -> tuple[Fit, float]:
        normal = rows[:, own].T @ rows[:, own] + np.diag(prior[own])
        mean = np.zeros(6)
        mean[own] = np.linalg.solve(normal, rows[:, own].T @ values)
        squares = np.sum((values - rows @ mean) ** 2) + prior @ mean**2
        return Fit(mean, own, np.linalg.cholesky(np.linalg.inv(normal))), float(squares)

    (a, before_a), (b, before_b) = (fit(recorded, measured, own) for own in used.values())
    foretold = new @ a.mean
    rows, values = np.vstack((recorded, new)), np.concatenate((measured, foretold))
    (_, after_a), (_, after_b) = (fit(rows, values, own) for own in used.values())
    assert after_a == pytest.approx(before_a)
    assert expected_gain(a, b, new.T @ new) == pytest.approx(0.5 * (after_b - before_b))
    assert expected_gain(a, a, new.T @ new) == pytest.approx(0.0, abs=1e-9)


def test_faster_motion_tells_a_delay_from_a_lag(
    workspace: Workspace, runs: tuple[PossibleRun, ...]
) -> None:
    names = ("landmarks", "faster", "unload_left")
    found = told(workspace, runs, names, ("latency (left)", [0.04]), "low_pass (left)")
    for other in ("landmarks", "unload_left"):
        assert found["faster"][0, 1] > 2.0 * found[other][0, 1]


def test_turning_the_robot_tells_the_floor_from_the_body(
    workspace: Workspace, runs: tuple[PossibleRun, ...]
) -> None:
    body = ("joint_offset (LAnkleRoll)", "link_com (base_link)")
    names = ("landmarks", TURNED)
    found = told(workspace, runs, names, ("floor_tilt", [0.004, 0.002]), *body)
    assert (found[TURNED][0, 1:] > 3.0 * found["landmarks"][0, 1:]).all()


def test_time_tells_a_drift_of_zeros_from_one_of_gains(
    workspace: Workspace, runs: tuple[PossibleRun, ...]
) -> None:
    names = ("hold", WARM)
    found = told(workspace, runs, names, ("zero_drift (left)", [3e-4]), "span_drift (left)")
    assert found[WARM][0, 1] > 3.0 * found["hold"][0, 1]


def test_unloading_tells_a_tilted_floor_from_an_ankle(
    workspace: Workspace, runs: tuple[PossibleRun, ...]
) -> None:
    names = ("landmarks", "unload_left")
    rival = "joint_offset (LAnkleRoll)"
    found = told(workspace, runs, names, ("floor_tilt", [0.004, 0.002]), rival)
    assert found["unload_left"][0, 1] > 2.0 * found["landmarks"][0, 1]


def test_exact_twins_stay_twins_whatever_is_run(
    workspace: Workspace, runs: tuple[PossibleRun, ...]
) -> None:
    pair = "crosstalk (left/rear_left, left/front_left)", "cell_position (left/front_left)"
    session, fits = rivals.where(workspace, pair[0], [0.05], pair[1])
    some = [run for run in runs if run.name in ("unload_left", "yawed_stance", TURNED)]
    found = separations(session, fits, some, SETTINGS)
    assert max(one.gains.max() for one in found) < 3.0
    assert chosen(found, fits, SETTINGS) is None


def test_a_proposal_names_what_it_tells_apart(workspace: Workspace) -> None:
    session, fits = rivals.where(workspace, "soft_ground (left)", [0.002], "foot_placement (left)")
    heard: list[float] = []
    found = propose(session, fits, SETTINGS, progress=lambda _text, share: heard.append(share))
    assert found is not None
    assert found.separates == ("soft_ground (left)", "foot_placement (left)")
    assert heard == sorted(heard)
    assert heard


def test_nothing_is_proposed_where_nothing_is_confused(workspace: Workspace) -> None:
    session, fits = rivals.where(workspace, "floor_tilt", [0.004, 0.002])
    assert propose(session, fits, SETTINGS) is None
    assert propose(session, [], SETTINGS) is None


def test_a_moments_effect_adds_nothing_to_runs_to_come(
    workspace: Workspace, runs: tuple[PossibleRun, ...]
) -> None:
    slips = ("slip (left)", [0.004, 0.0, 0.0]), "slip (right)"
    (gains,) = told(workspace, runs, ("landmarks",), *slips).values()
    assert np.isfinite(gains).all()


def test_what_the_next_diagnosis_will_believe_is_foreseen(
    workspace: Workspace, runs: tuple[PossibleRun, ...]
) -> None:
    session, fits = rivals.where(workspace, "floor_tilt", [0.004, 0.002], "link_com (base_link)")
    some = [run for run in runs if run.name in ("torso_tilt", TURNED)]
    little, turned = separations(session, fits, some, SETTINGS)
    np.testing.assert_allclose(turned.after.sum(axis=1), 1.0)
    # Each is believed where it is true; a run that tells nothing leaves both as they were.
    assert (np.diag(turned.after) > 0.95).all()
    assert turned.worth > 0.9 > little.worth
    assert chosen([little], fits, SETTINGS) is None


@pytest.mark.parametrize(("own_worth", "expected"), [(0.9, "reversed"), (0.6, TURNED)])
def test_a_person_is_asked_only_where_that_is_clearly_better(
    workspace: Workspace, own_worth: float, expected: str
) -> None:
    _, fits = rivals.where(workspace, "latency (left)", [0.03], "low_pass (left)")
    gains, clear = np.full((2, 2), 90.0), np.eye(2)
    some = [Separation(name, gains, clear, worth)
            for name, worth in (("reversed", own_worth), (TURNED, 1.0))]  # fmt: skip
    found = chosen(some, fits, SETTINGS)
    assert found is not None
    assert found.motion == expected


def test_what_a_run_does_not_separate_is_not_named(workspace: Workspace) -> None:
    _, fits = rivals.where(
        workspace,
        "latency (left)",
        [0.03],
        "low_pass (left)",
        "latency (right)",
        "low_pass (right)",
    )
    after = np.array(
        [[0.6, 0.2, 0.0, 0.2], [0.4, 0.4, 0.0, 0.2], [0.0, 0.0, 1.0, 0.0], [0.3, 0.3, 0.0, 0.4]]
    )
    after[[1, 3], 2] = after[2, [1, 3]] = 0.1
    found = chosen([Separation("faster", np.zeros((4, 4)), after, 0.4)], fits, SETTINGS)
    assert found is not None
    assert found.separates == ("latency (left)", "latency (right)")


def test_a_run_that_would_hardly_help_is_not_proposed(workspace: Workspace) -> None:
    _, fits = rivals.where(workspace, "latency (left)", [0.03], "low_pass (left)")
    doubtful = [(fits[0][0], 0.7), (fits[1][0], 0.3)]
    # Only where the less probable one is true would the other one leave.
    after = np.array([[0.8, 0.2], [0.0, 1.0]])
    one = Separation("faster", np.zeros((2, 2)), after, 0.4)
    assert chosen([one], doubtful, SETTINGS) is None
    assert chosen([one], doubtful[::-1], SETTINGS) is not None

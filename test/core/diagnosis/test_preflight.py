"""What a session would not show, and what it takes for something else."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations

import numpy as np

from core.diagnosis.drawn import remade
from shoecal_core.diagnosis.preflight import (
    Preflight,
    distances,
    preflight,
    typical_sizes,
    unexplained,
)
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.posterior import Posterior

SETTINGS = DiagnosisSettings()
CELLS = ("front_left", "front_right", "rear_left", "rear_right")


def trained_on(workspace: Workspace, *runs: int) -> Preflight:
    return preflight(on(workspace, *runs), SETTINGS)


def on(workspace: Workspace, *runs: int) -> Workspace:
    return replace(workspace, train=runs, sums=remade(workspace, runs))


def paired(found: Preflight) -> set[frozenset[str]]:
    """All pairs that stand in one set."""
    return {frozenset(pair) for one in found.cannot_separate for pair in combinations(one, 2)}


def test_what_is_left_of_columns_is_what_a_fit_of_the_baseline_leaves(workspace: Workspace) -> None:
    left = unexplained(workspace)
    base, products = workspace.sums.base, workspace.sums.products
    baseline = Posterior(products[:base, :base], workspace.sums.precision)
    for column in (0, 40, 200):
        right = products[:base, base + column]
        squares = products[base + column, base + column] - right @ baseline.solve(right)
        np.testing.assert_allclose(left[column, column], squares, rtol=1e-4)


def test_a_share_of_a_cells_force_looks_like_that_cell_elsewhere(workspace: Workspace) -> None:
    pairs = paired(preflight(workspace, DiagnosisSettings(false_alarms=0.5)))
    for receiver in CELLS[1:]:
        donor = f"left/{CELLS[0]}"
        crosstalk = f"crosstalk (left/{receiver}, {donor})"
        assert frozenset((crosstalk, f"cell_position ({donor})")) in pairs


def test_a_delay_looks_more_like_a_lag_in_slow_motion(workspace: Workspace) -> None:
    labels = [hypothesis.label for hypothesis in workspace.catalogue.hypotheses]
    one, other = labels.index("latency (left)"), labels.index("low_pass (left)")

    def apart(*runs: int) -> float:
        part = on(workspace, *runs)
        hypotheses = part.catalogue.hypotheses
        return float(distances(hypotheses, unexplained(part), typical_sizes(part))[one, other])

    faster = 3
    assert apart(1, 2, faster) > 1.5 * apart(1, 2)
    twins = frozenset(("latency (left)", "low_pass (left)"))
    assert twins in paired(trained_on(workspace, 1, 2))


def test_different_motions_show_more(workspace: Workspace) -> None:
    unseen = [
        len(trained_on(workspace, *runs).cannot_detect)
        for runs in ((1,), (1, 2), (1, 2, 3), tuple(range(1, 7)))
    ]
    assert unseen == sorted(unseen, reverse=True)
    assert unseen[0] > unseen[2]


def test_unloading_tells_apart_what_double_supports_do_not(workspace: Workspace) -> None:
    both = trained_on(workspace, 1, 2, 3, 4)
    everything = trained_on(workspace, *range(1, 7))
    assert len(paired(everything)) < len(paired(both))


def test_lines_name_effect_foot_and_how_many(workspace: Workspace) -> None:
    strict = preflight(workspace, DiagnosisSettings(false_alarms=1e-6))
    assert "crosstalk between cells of the left foot (12 of 12 places)" in strict.cannot_detect
    assert "floor_tilt" in strict.cannot_detect
    assert any(line.startswith("drifts with temperature") for line in strict.cannot_detect)


def test_the_fewer_places_are_named_of_those_that_show_and_those_that_do_not(
    workspace: Workspace,
) -> None:
    def line(evidence_min: float) -> str:
        settings = DiagnosisSettings(false_alarms=1.0 / (1.0 + math.exp(evidence_min)))
        (one,) = (x for x in preflight(workspace, settings).cannot_detect if "payload" in x)
        return one

    assert "places: " in line(0.3)
    assert "all but " in line(8.0)


def test_missing_channels_are_told(workspace: Workspace) -> None:
    samples = workspace.signal_model.samples
    tracks = tuple(replace(track, up=None, efforts=None) for track in samples.tracks)
    signal_model = replace(workspace.signal_model, samples=replace(samples, tracks=tracks))
    lines = preflight(replace(workspace, signal_model=signal_model), SETTINGS).cannot_detect
    assert any(line.startswith("off_axis_load: joint efforts") for line in lines)
    assert any("/imu" in line for line in lines)


def test_a_hypothesis_is_at_no_distance_from_itself(workspace: Workspace) -> None:
    hypotheses = workspace.catalogue.hypotheses[:20]
    found = distances(hypotheses, unexplained(workspace), typical_sizes(workspace))
    assert (np.diag(found) == 0.0).all()
    assert (found >= 0.0).all()


def test_an_effect_is_typical_where_it_moves_the_cop_by_a_millimetre(workspace: Workspace) -> None:
    sizes = typical_sizes(workspace)
    known = {hypothesis.label: hypothesis for hypothesis in workspace.catalogue.hypotheses}
    tilt = known["floor_tilt"].forms[0]
    columns = workspace.catalogue.columns[list(tilt.columns)][:, workspace.rows_of(workspace.train)]
    moved = np.linalg.norm(columns[:, :, 1:3], axis=2).mean(axis=1) * sizes[list(tilt.columns)]
    np.testing.assert_allclose(moved, 0.001)
    light = known["link_com (Neck_link)"].forms[0]
    np.testing.assert_array_equal(sizes[list(light.columns)], light.std)

"""Runs that have not happened: as they would be recorded were nothing wrong."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from shoecal_core.diagnosis.candidates import BY_HAND, STANCES, WARM, YAWED
from shoecal_core.diagnosis.forecast import PossibleRun, extended
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.effects.contact import TURNED, FloorTilt
from shoecal_core.error_sources.scene import Scene
from shoecal_core.error_sources.signals import AIR, COP, GRF, PARITY, TILT
from shoecal_core.model.robot import GRAVITY
from shoecal_core.planning.motion_catalogue import MOTION_KINDS
from shoecal_core.samples.known_weight import WEIGHTED


@pytest.fixture(scope="module")
def scene(workspace: Workspace, runs: tuple[PossibleRun, ...]) -> Scene:
    return extended(workspace.scene, runs)


def of(scene: Scene, name: str) -> NDArray[np.bool_]:
    """(T,) samples of the last run of a name."""
    last = [track.run for track in scene.samples.tracks if track.motion == name][-1]
    return np.asarray(scene.samples.run == last)


def test_the_whole_menu_can_be_run(runs: tuple[PossibleRun, ...]) -> None:
    assert [run.name for run in runs] == [*MOTION_KINDS, *STANCES, *BY_HAND]


def test_recorded_runs_stay_as_they_are(workspace: Workspace, scene: Scene) -> None:
    before = workspace.scene
    count, base = len(before.samples.run), len(before.baseline)
    assert scene.samples.run[:count].tolist() == before.samples.run.tolist()
    assert scene.samples.run[count] == max(before.samples.runs) + 1
    np.testing.assert_array_equal(scene.residuals[:count], before.residuals)
    np.testing.assert_allclose(scene.baseline[:base, :count], before.baseline, atol=1e-12)
    # Each is an alternative: it begins after all that were recorded.
    assert scene.samples.clock[count:].min() > before.samples.clock.max()


def test_nothing_is_wrong_in_a_run_that_has_not_happened(
    workspace: Workspace, scene: Scene
) -> None:
    coming = scene.samples.run > max(workspace.scene.samples.runs)
    rest = scene.residuals[coming]
    # The weight is shared so that the wrenches are the model's.
    np.testing.assert_allclose(rest[:, GRF], 0.0, atol=1e-6)
    np.testing.assert_allclose(rest[:, COP], 0.0, atol=2e-5)
    np.testing.assert_allclose(rest[:, AIR], 0.0, atol=1e-6)
    np.testing.assert_allclose(rest[:, TILT], 0.0, atol=1e-4)
    # Cells lie on the plane on which they were seen to lie.
    there = scene.mask[coming][:, PARITY]
    usual = scene.residuals[: len(workspace.scene.samples.run), PARITY]
    for foot in (0, 1):
        seen = usual[workspace.scene.samples.loaded[:, foot], foot].mean()
        np.testing.assert_allclose(rest[there[:, foot], PARITY.start + foot], seen, atol=1e-6)


def test_a_run_looks_as_its_recording_does(scene: Scene) -> None:
    # Run 1 was recorded in the support in which landmarks are forecast again.
    recorded, foreseen = scene.samples.run == 1, of(scene, "landmarks")
    assert abs(np.count_nonzero(recorded) - np.count_nonzero(foreseen)) < 25
    for values in (scene.samples.cop, scene.outputs):
        np.testing.assert_allclose(
            np.sort(values[foreseen], axis=0).mean(axis=0),
            np.sort(values[recorded], axis=0).mean(axis=0),
            atol=0.15 * np.ptp(values),
        )


@pytest.mark.parametrize(("name", "standing"), [("unload_left", 1), ("unload_right", 0)])
def test_one_foot_is_in_the_air_for_a_while(scene: Scene, name: str, standing: int) -> None:
    loaded = scene.samples.loaded[of(scene, name)]
    assert loaded[:, standing].all()
    assert 0.1 < 1.0 - loaded[:, 1 - standing].mean() < 0.6
    segments = scene.samples.segment[of(scene, name)]
    assert len(np.unique(segments)) == 3
    assert (np.diff(segments) >= 0).all()


def test_a_known_weight_is_carried(scene: Scene) -> None:
    robot, part = scene.samples.robot, of(scene, WEIGHTED)
    mass = BY_HAND[WEIGHTED].mass
    np.testing.assert_allclose(scene.samples.force[part], robot.weight + mass * GRAVITY)
    np.testing.assert_allclose(scene.wrench[part, 0], robot.weight + mass * GRAVITY)
    assert not np.allclose(scene.samples.cop[part], scene.samples.cop[of(scene, "landmarks")])


def test_warming_up_takes_time(scene: Scene) -> None:
    clock = scene.samples.clock
    before = clock[of(scene, "landmarks")].min()
    assert clock[of(scene, WARM)].min() - before > 0.9 * BY_HAND[WARM].later


def test_temperature_rises_where_it_was_recorded(
    workspace: Workspace, runs: tuple[PossibleRun, ...]
) -> None:
    samples = workspace.scene.samples
    tracks = tuple(
        replace(track, temperature=np.full(len(track.time), 20.0)) for track in samples.tracks
    )
    known = replace(workspace.scene, samples=replace(samples, tracks=tracks))
    warm = [run for run in runs if run.name in (WARM, "hold")]
    told = [track.temperature for track in extended(known, warm).samples.tracks[-2:]]
    assert [None if one is None else float(one[-1]) for one in told] == [20.0, 23.0]


def test_without_an_imu_none_is_foreseen(
    workspace: Workspace, runs: tuple[PossibleRun, ...]
) -> None:
    samples = workspace.scene.samples
    tracks = tuple(replace(track, up=None) for track in samples.tracks)
    blind = replace(samples, tracks=tracks, up=np.full_like(samples.up, np.nan))
    scene = extended(replace(workspace.scene, samples=blind), runs[:1])
    assert not scene.mask[:, TILT].any()


def test_the_floor_leans_the_other_way_once_the_robot_is_turned(scene: Scene) -> None:
    (shape,) = FloorTilt().shapes(scene, ())
    here, turned = of(scene, "landmarks"), of(scene, TURNED)
    np.testing.assert_allclose(shape.columns[:, turned], -shape.columns[:, here], atol=1e-9)


def test_a_yawed_stance_has_much_yaw(scene: Scene) -> None:
    (segment,) = np.unique(scene.samples.segment[of(scene, YAWED)])
    assert abs(scene.supports[segment].dtheta) > 0.4


@pytest.mark.parametrize(("name", "side"), [("left_foot_ahead", -1.0), ("right_foot_ahead", 1.0)])
def test_a_foot_stands_ahead(scene: Scene, name: str, side: float) -> None:
    (segment,) = np.unique(scene.samples.segment[of(scene, name)])
    assert side * scene.supports[segment].dx > 0.03

"""What the soles tell of a joint that gives, on a recording in which one was made to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from core.diagnosis.drawn import Urn
from core.error_sources.altered import with_angles
from shoecal_core.diagnosis.selection import ranked, select
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.workspace import Workspace, make_workspace
from shoecal_core.error_sources.effects.known import EFFECTS
from shoecal_core.error_sources.give import LEVER
from shoecal_core.error_sources.scene import Scene
from shoecal_core.error_sources.signals import CLOSURE

FloatArray = NDArray[np.float64]
SETTINGS = DiagnosisSettings()
FAR = 0.012
"""rad; to either side."""


def wandering(scene: Scene, joint: int) -> FloatArray:
    """(T, m) a joint that lies now on this side of its play, now on that, whatever it holds."""
    samples = scene.samples
    change = np.zeros_like(samples.angles)
    swing = np.sin(2.0 * np.pi * samples.time / 17.0 + samples.run)
    change[:, joint] = FAR * np.tanh(4.0 * swing)
    return change


@pytest.mark.parametrize("name", ["LKneePitch", "RHipPitch", "LAnkleRoll"])
def test_the_soles_tell_the_course_of_one_joint(workspace: Workspace, name: str) -> None:
    scene = workspace.scene
    joint = scene.samples.robot.joint(name)
    change = wandering(scene, joint)
    after = with_angles(scene, change)
    told = (after.give.of([joint]).course - scene.give.of([joint]).course)[:, 0]
    both = scene.samples.both
    truth = change[both, joint]
    assert np.corrcoef(told[both], truth)[0, 1] > 0.97
    assert np.std(told[both]) == pytest.approx(np.std(truth), rel=0.15)
    assert not told[~both].any()


def test_the_joint_that_wandered_explains_more_of_the_soles_than_any_other(
    workspace: Workspace,
) -> None:
    scene = workspace.scene
    robot = scene.samples.robot
    joint = robot.joint("RHipPitch")
    after = with_angles(scene, wandering(scene, joint))

    def left(other: int) -> float:
        change = np.zeros_like(after.samples.angles)
        change[:, other] = after.give.of([other]).course[:, 0]
        rest = (after.residuals - after.by_angles(change))[:, CLOSURE]
        return float(np.mean(rest**2 / np.array([LEVER**2] * 3 + [1.0] * 3)))

    squares = {other: left(other) for other in robot.moved.tolist()}
    assert min(squares, key=squares.__getitem__) == joint


def test_what_follows_the_torque_is_compliance_and_what_does_not_is_not(
    workspace: Workspace,
) -> None:
    scene = workspace.scene
    joint = scene.samples.robot.joint("LKneePitch")
    follows = np.where(scene.samples.both[:, None], 0.01 * scene.torque[:, [joint]], 0.0)
    assert scene.give.with_torque([joint], follows) == pytest.approx(0.01)
    assert scene.give.with_torque([joint], -follows) is None
    assert scene.give.with_torque([joint], wandering(scene, joint)[:, [joint]]) is None


def test_more_joints_cost_more_but_never_more_than_a_pose_has_numbers(
    workspace: Workspace,
) -> None:
    costs = [workspace.scene.give.of(range(count)).spent for count in (1, 2, 6, 12)]
    np.testing.assert_allclose(np.array(costs) / costs[0], [1.0, 2.0, 6.0, 6.0])


def test_joints_are_worked_out_once(workspace: Workspace) -> None:
    scene = workspace.scene
    joint = scene.samples.robot.joint("LKneePitch")
    assert scene.give.of([joint]) is scene.give.of([joint])
    assert scene.with_parameters(scene.parameters).give is not scene.give


@pytest.mark.parametrize(("over", "believed"), [(0.6, False), (1.6, True)])
def test_what_is_read_from_the_soles_must_explain_twice_what_it_cost(
    urn: Urn, over: float, believed: bool
) -> None:
    """A course that the soles tell, so large that it explains its cost and this much of it more."""
    workspace = urn.workspace
    told = [
        (one, form)
        for one in workspace.catalogue.hypotheses
        for form in one.forms
        if one.effect.identifier == "backlash" and form.shape.spent > 0.0
    ]
    read = told[0]
    (column,) = workspace.catalogue.columns[list(read[1].columns)]
    noise = urn.draw(np.random.default_rng(1)).scene.residuals

    def left_over(size: float) -> float:
        """Of the evidence, over what the course cost."""
        scored = urn.showing(noise + size * column).scorer.score([read], foretell=False)
        return scored.evidence / read[1].shape.spent

    high = 0.01
    while left_over(high) < over:
        high *= 2.0
    low = 0.5 * high
    for _ in range(6):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if left_over(middle) < over else (low, middle)
    drawn = urn.showing(noise + high * column)
    best = drawn.scorer.best_form(read[0])
    assert best.parts[0][1] is read[1]
    assert best.evidence > SETTINGS.evidence_min
    ranking = ranked(drawn, replace(SETTINGS, material=0.0))
    forms = [form for one in ranking for hypothesis, form in one.parts if hypothesis is read[0]]
    assert any(form.shape.spent > 0.0 for form in forms) is believed


def test_play_that_no_torque_tells_is_named(workspace: Workspace) -> None:
    scene = workspace.scene
    after = with_angles(scene, wandering(scene, scene.samples.robot.joint("LHipPitch")))
    found = select(
        make_workspace(after, EFFECTS, workspace.train, workspace.test, SETTINGS), SETTINGS
    )
    assert found.chosen is not None
    hypothesis, form = found.chosen.parts[0]
    assert hypothesis.label == "backlash (LHipPitch)"
    assert form.shape.spent > 0.0
    assert found.chosen.sizes[0] == pytest.approx(2.0 * FAR, rel=0.35)

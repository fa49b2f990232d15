"""Unknowns of body and shoes: what they change, and that they are found again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from shoecal_core.calibration.refinement.found_effects import FoundEffect, FoundEffects
from shoecal_core.calibration.refinement.reference import Reference
from shoecal_core.calibration.refinement.refine import Refinement, refine
from shoecal_core.calibration.refinement.refined import refined
from shoecal_core.calibration.refinement.unknowns import (
    Unknown,
    can_be_fitted,
    column_change,
    tolerated,
    with_found,
)

from core.calibration import synthetic
from core.model import robots
from core.sensing import shoes
from shoecal_core.calibration.fit import self_calibrate
from shoecal_core.calibration.settings import CalibrationSettings
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.errors import NameNotFoundError, ShoecalError
from shoecal_core.model.kinematics import Kinematics
from shoecal_core.samples.stance import Stance
from shoecal_core.sensing.shoe import Shoe
from shoecal_core.sensing.wrench import ChannelParameters, columns_in_left

FloatArray = NDArray[np.float64]
SHOE, ROBOT = shoes.shoe("nao_shoe"), robots.load("nao")
SETTINGS = CalibrationSettings(cop_std_m=0.0005, correction_std_m=0.0, time_offset_std_s=0.0)
CELL = Unknown("cell_position", ("left/front_left",), "x", 0.0, 0.005)
PLATES = Unknown("plates", ("right",), "share_y", 0.0, 0.2)
CROSSTALK = Unknown("crosstalk", ("left/front_left", "left/rear_left"), "fraction", 0.0, 0.1)
GEARS = Unknown("joint_compliance", ("all",), "compliance", 0.0, 0.01)


@pytest.fixture(scope="module")
def reference() -> Reference:
    return Reference(ROBOT)


def made(worn: Shoe, seed: int = 1) -> tuple[ChannelParameters, list[Stance]]:
    """Recordings on these shoes, told as if on the shoe of the file; each foot hangs once."""
    rng = np.random.default_rng(seed)
    law = synthetic.truth(worn, rng)
    stances = synthetic.stances(worn, law, rng, synthetic.SUPPORTS[:3], weight=ROBOT.weight)
    stances += [
        synthetic.single_stance(worn, law, foot, rng, run=4 + foot, weight=ROBOT.weight)
        for foot in (0, 1)
    ]
    return law, [_with_a_body(one, rng) for one in stances]


def _with_a_body(stance: Stance, rng: np.random.Generator) -> Stance:
    """The same told on the file's shoe, with joint angles and torques that change slowly."""
    joints = len(ROBOT.posture)
    waves = np.sin(
        np.outer(stance.time, rng.uniform(0.2, 0.8, joints)) + rng.uniform(0.0, 6.0, joints)
    )
    if all(stance.loaded):
        columns = columns_in_left(SHOE, stance.support)
    else:
        columns = np.where((SHOE.foot == stance.hanging)[:, None], 0.0, SHOE.columns)
    return replace(
        stance, angles=ROBOT.posture + 0.1 * waves, efforts=waves[:, ::-1], columns=columns
    )


def standing_still(stances: Sequence[Stance]) -> list[Stance]:
    """Under the weight alone."""
    return [
        replace(stance, force=np.full(len(stance.time), float(stance.force.mean())))
        for stance in stances
    ]


def fitted(
    reference: Reference, stances: Sequence[Stance], unknowns: Sequence[Unknown]
) -> Refinement:
    return refine(SHOE, stances, reference, unknowns, SETTINGS)


@pytest.mark.parametrize("unknown", [CELL, PLATES, CROSSTALK], ids=lambda one: one.effect)
def test_what_is_wrong_with_a_shoe_is_found(reference: Reference, unknown: Unknown) -> None:
    size = 0.4 * unknown.std
    worn = SHOE.with_columns(SHOE.columns + size * column_change(unknown, SHOE))
    law, stances = made(worn)
    found = fitted(reference, stances, [unknown])
    (one,) = found.fitted
    assert one.value == pytest.approx(size, rel=0.15)
    assert one.std < 0.5 * unknown.std
    np.testing.assert_allclose(found.shoe.columns, worn.columns, atol=0.1 * abs(size))
    stages = self_calibrate(found.shoe, [found.correct(one) for one in stances], SETTINGS)
    np.testing.assert_allclose(stages.parameters.gain, law.gain, rtol=0.01)


@pytest.mark.parametrize(
    ("effect", "location", "component", "size"),
    [
        ("joint_offset", "LAnkleRoll", "angle", 0.004),
        ("joint_compliance", "all", "compliance", 0.004),
        ("backlash", "all", "play", 0.004),
        ("link_com", "root_joint", "x", 0.004),
        ("payload", "root_joint", "mass", 0.05),
    ],
)
def test_what_is_wrong_with_the_body_is_found(
    reference: Reference, effect: str, location: str, component: str, size: float
) -> None:
    unknown = Unknown(effect, (location,), component, 0.0, 2.0 * size)
    _, stances = made(SHOE)
    extra = size * 9.81 if effect == "payload" else 0.0
    wrong = [
        replace(
            stance,
            cop=stance.cop - size * reference.shifts(stance, [unknown])[:, :, 0],
            force=stance.force - extra,
        )
        for stance in stances
    ]
    found = fitted(reference, wrong, [unknown])
    (one,) = found.fitted
    assert one.value == pytest.approx(size, rel=0.1)
    for before, after in zip(stances, wrong, strict=True):
        np.testing.assert_allclose(found.correct(after).cop, before.cop, atol=3e-4)


@pytest.mark.parametrize("foot", [0, 1])
def test_a_joint_that_tells_too_much(reference: Reference, foot: int) -> None:
    """The CoP goes where the angles without the offset put it, on shared motors too."""
    _, stances = made(SHOE)
    stance = stances[3 + foot].part(slice(5))
    kinematics, step = Kinematics(ROBOT), 1e-5
    assert stance.angles is not None
    for name in ("LHipYawPitch", "RKneePitch"):
        leader = ROBOT.joint(name)
        turn = np.eye(len(ROBOT.posture))[leader]
        for shared in ROBOT.shared:
            if shared.leader == leader:
                turn[shared.joint] = shared.ratio
        ends = [
            kinematics.states(stance.angles + sign * step * turn).cop[:, foot] for sign in (-1, 1)
        ]
        found = reference.shifts(stance, [Unknown("joint_offset", (name,), "angle", 0.0, 1.0)])
        np.testing.assert_allclose(found[:, :, 0], (ends[0] - ends[1]) / (2 * step), atol=1e-6)


def test_a_link_by_its_own_name_or_its_joints(reference: Reference) -> None:
    _, stances = made(SHOE)
    few = stances[0].part(slice(3))
    one, other = (
        reference.shifts(few, [Unknown("link_com", (name,), "y", 0.0, 1.0)])
        for name in ("base_link", "root_joint")
    )
    np.testing.assert_array_equal(one, other)
    with pytest.raises(NameNotFoundError, match="no link named 'tail'"):
        reference.shifts(few, [Unknown("link_com", ("tail",), "y", 0.0, 1.0)])


def test_what_a_diagnosis_found_is_believed() -> None:
    told = tolerated(ROBOT, SHOE, ("root_joint",), Tolerances(), efforts=False)
    assert not any(one.effect in {"joint_compliance", "backlash"} for one in told)
    found = FoundEffect("cell_position", CELL.location, {"x": (0.001, 1e-5)})
    extra = FoundEffect("crosstalk", CROSSTALK.location, {"fraction": (-0.02, 0.001)})
    believed = {one.name: one for one in with_found(told, [found, extra])}
    assert len(believed) == len(told) + 1
    assert believed[CELL.name].mean == 0.001
    assert believed[CELL.name].std == Tolerances().cell_position_m
    assert believed[CROSSTALK.name].std == 0.02


@pytest.mark.parametrize(
    ("odd", "told"),
    [
        (FoundEffect("joint_offset", (), {"angle": (0.01, 0.001)}), "needs 1 in its location"),
        (FoundEffect("crosstalk", ("left/a",), {"fraction": (0.1, 0.01)}), "needs 2"),
        (FoundEffect("payload", ("base",), {"weight": (0.1, 0.01)}), "other components than mass"),
    ],
)
def test_what_no_diagnosis_says(odd: FoundEffect, told: str) -> None:
    with pytest.raises(ShoecalError, match=told):
        with_found([], [odd])


def test_crosstalk_from_foot_to_foot_is_no_column() -> None:
    cells = ("left/front_left", "right/front_left")
    assert not can_be_fitted(FoundEffect("crosstalk", cells, {}))
    assert can_be_fitted(FoundEffect("crosstalk", CROSSTALK.location, {}))


def test_without_a_foot_in_the_air_the_model_is_trusted_less() -> None:
    stances = standing_still(made(SHOE)[1])
    nothing = FoundEffects(ROBOT.name, SHOE.name, "unknown", ())
    usual = CalibrationSettings()
    lifted = refined(ROBOT, SHOE, stances, nothing, usual, Tolerances())
    standing = refined(ROBOT, SHOE, stances[:3], nothing, usual, Tolerances())
    assert lifted.settings.cop_std_m < standing.settings.cop_std_m == usual.cop_std_m
    sides = {one["side"] for one in lifted.to_json()}
    assert sides == {"measuring", "model"}


def test_what_cannot_be_fitted_is_told() -> None:
    stances = standing_still(made(SHOE)[1])
    stances = [replace(stance, efforts=None) for stance in stances]
    causes = (
        FoundEffect("hysteresis", ("left",), {"fraction": (0.02, 0.001)}),
        FoundEffect("joint_compliance", ("all",), {"compliance": (0.004, 0.001)}),
    )
    found = FoundEffects(ROBOT.name, SHOE.name, "explained", causes)
    told = refined(ROBOT, SHOE, stances, found, SETTINGS, Tolerances()).findings
    assert [one.verdict for one in told] == ["WARN", "WARN"]
    assert all("is not among what is fitted here" in one.reason for one in told)


@pytest.mark.parametrize("names", [("wren", "nao_shoe"), ("nao", "wren_shoe")])
def test_a_diagnosis_of_another_robot_or_shoe(names: tuple[str, str]) -> None:
    stances = standing_still(made(SHOE)[1])
    with pytest.raises(ShoecalError, match="the diagnosis is of"):
        refined(ROBOT, SHOE, stances, FoundEffects(*names, "unknown", ()), SETTINGS, Tolerances())

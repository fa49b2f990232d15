"""A calibration's step before the fit: what is allowed to be wrong, fitted and put right."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from shoecal_core.calibration.checks import Finding
from shoecal_core.calibration.refinement.choice import Choice, choose
from shoecal_core.calibration.refinement.found_effects import FoundEffect, FoundEffects
from shoecal_core.calibration.refinement.reference import Reference
from shoecal_core.calibration.refinement.refine import Evidence, Refinement, refine
from shoecal_core.calibration.refinement.unknowns import (
    BODY,
    GEARS,
    MEASURING,
    as_if_unseen,
    can_be_fitted,
    tolerated,
    with_found,
)
from shoecal_core.calibration.settings import CalibrationSettings
from shoecal_core.calibration.tolerances import Tolerances
from shoecal_core.errors import ShoecalError
from shoecal_core.model.robot import Robot
from shoecal_core.samples.stance import Stance
from shoecal_core.sensing.shoe import Shoe

COP_STD_M = 0.0005
"""How far the CoP of a model is off whose errors are fitted, too; where no foot was in the air,
weakly fixed directions do not bear so much trust, and it is taken as the settings say."""


@dataclass(frozen=True)
class Refined:
    """The refinement of a calibration.

    Attributes:
        refinement: the corrected shoe and reference, and all sizes.
        settings: of the fit that follows: the reference is better, and no polynomial may swallow
            what is left.
        findings: effects that could not be fitted.
        choice: which of the others are fitted.
    """

    refinement: Refinement
    settings: CalibrationSettings
    findings: tuple[Finding, ...]
    choice: Choice

    def to_json(self) -> list[dict[str, object]]:
        """Every unknown as it was fitted, SI units."""
        return [
            {
                "effect": one.unknown.effect,
                "location": list(one.unknown.location),
                "component": one.unknown.component,
                "value": one.value,
                "std": one.std,
                "side": "measuring" if one.unknown.effect in MEASURING else "model",
            }
            for one in self.refinement.fitted
        ]


def refined(
    robot: Robot,
    shoe: Shoe,
    stances: Sequence[Stance],
    effects: FoundEffects,
    settings: CalibrationSettings,
    tolerances: Tolerances,
) -> Refined:
    """Fit what files of robot and shoes may be wrong by, and what a diagnosis found.

    Of what it was not sure of, only as much as the stances bear out: see `choice`.

    Args:
        robot, shoe: as their files say.
        stances: to fit.
        effects: found.
        settings, tolerances: of the calibration.

    Raises:
        ShoecalError: a diagnosis of another robot or shoe, or a walk.
    """
    _require(robot, shoe, stances, effects)
    efforts = all(stance.efforts is not None for stance in stances)
    fitting, findings = _that_can_be_fitted(effects, efforts=efforts)
    reference = Reference(robot)
    usual = tolerated(robot, shoe, reference.body.links, tolerances, efforts=efforts)
    lifted = {stance.hanging for stance in stances} - {None}
    trusted = min(settings.cop_std_m, COP_STD_M) if len(lifted) == 2 else settings.cop_std_m
    settings = replace(settings, cop_std_m=trusted, correction_std_m=0.0)

    def evidence(some: Sequence[FoundEffect]) -> Evidence:
        unknowns = with_found(usual, [as_if_unseen(one) for one in some])
        return refine(shoe, stances, reference, unknowns, settings).evidence

    choice = choose(fitting, effects.sure, evidence)
    unknowns = with_found(usual, choice.fitted)
    refinement = refine(shoe, stances, reference, unknowns, settings)
    return Refined(refinement, settings, findings, choice)


def _require(robot: Robot, shoe: Shoe, stances: Sequence[Stance], effects: FoundEffects) -> None:
    """Refuse a diagnosis of another robot or shoe, and walks."""
    for kind, told, own in (
        ("robot", effects.robot, robot.name),
        ("shoe", effects.shoe, shoe.name),
    ):
        if told != own:
            raise ShoecalError(
                f"the diagnosis is of {kind} '{told}', the session of '{own}'; "
                "diagnose this session"
            )
    if not all(stance.quasi_static and stance.angles is not None for stance in stances):
        raise ShoecalError(
            "effects are fitted to runs in double support, or that lift one foot; leave walks out"
        )


def _that_can_be_fitted(
    effects: FoundEffects, *, efforts: bool
) -> tuple[list[FoundEffect], tuple[Finding, ...]]:
    """Those that can be, and a warning of each other one."""
    fitting = [
        one
        for one in effects.effects
        if can_be_fitted(one) and (efforts or one.effect not in GEARS)
    ]
    known = ", ".join(sorted((BODY | MEASURING) - (frozenset() if efforts else GEARS)))
    findings = tuple(
        Finding(
            "WARN",
            f"{one.label} was found, and is not among what is fitted here ({known}): it goes on to "
            "err",
        )
        for one in effects.effects
        if one not in fitting
    )
    return fitting, findings

"""Whether the budget of a calibration's CoP error holds each source's true share."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.estimation.joint_fit import FittedDeviation, JointFit
from shoecal_core.estimation.outcome import CalibrationOutcome
from shoecal_core.estimation.uncertainty.budget import NOISE, SUPPORT, mean_squares, unknowns
from shoecal_core.recording.session import Session
from shoecal_core.shoe.shoe import FEET
from shoecal_core.simulation.reality import PlantVariation
from true_sources import Source, read_drawn, true_sources

GEARS = ("joint_compliance", "backlash")


def hold_budget(
    session: Session, outcome: CalibrationOutcome, reality: PlantVariation
) -> Mapping[str, BoolArray]:
    """By source, (3,) whether its true share is inside its interval: of both feet, left, right.

    Where a foot stands is not recorded as truth: what the fit says of it is taken for true, and
    its source is left out. So are sideways forces, which no calibration estimates.

    Args:
        session: simulated, and calibrated.
        outcome: of that.
        reality: it was simulated in.
    """
    fit, stated = outcome.joint, outcome.assessment.budget
    assert fit is not None
    assert stated is not None
    wrong = _wrong(session, fit, reality)
    parts = mean_squares(fit, outcome.assessment.error_model, wrong[:, None])[:, :, 0]
    names = [*unknowns(fit), NOISE]
    beside = [one.size**2 for one in stated.sources if one.effect not in names]
    shares = parts.T / (parts.sum(axis=1) + np.sum(beside, axis=0))
    held = {}
    for name, share in zip(names, shares, strict=True):
        source = stated.source(name)
        if source is not None and name != "placement":
            low, high = source.interval.T
            held[name] = (low <= share) & (share <= high)
    return held


def _wrong(session: Session, fit: JointFit, reality: PlantVariation) -> FloatArray:
    """(u,) estimate less truth of all unknowns."""
    drawn, names = read_drawn(session), session.shoe.names
    channels = [drawn[law][name] for law in ("gain", "offset") for name in names]
    found = dict(true_sources(session))
    links = fit.signal_model.links
    for link, mass in zip(links.names, links.mass, strict=True):
        found["link_mass", (link,), "share"] = found["payload", (link,), "mass"] / mass
    stiffness = reality.cells.stiffness_n_per_m
    for foot in FEET:
        own = [name for name in names if name.startswith(foot)]
        places = np.array(
            [[found["cell_position", (name,), axis] for axis in "xy"] for name in own]
        )
        places += session.shoe.positions[[names.index(name) for name in own]]
        carried = 1.0 - float(drawn["clamp_share"][foot])
        give = carried / (stiffness * ((places - places.mean(axis=0)) ** 2).sum(axis=0))
        # It differs between the axes; the fit has one number for both.
        found["soft_ground", (foot,), "compliance"] += float(give.mean())
        for axis in "xy":
            found["plates", (foot,), axis] = 1.0 / carried - 1.0
    deviations = [one.value - _true(one, found) for one in fit.deviations]
    return np.concatenate((fit.vector - np.append(channels, 0.0), deviations))


def _true(one: FittedDeviation, found: Mapping[Source, float]) -> float:
    """True size of a deviation."""
    effect, place = one.deviation.effect, one.deviation.location
    if effect == SUPPORT:
        return one.value
    if effect == "zero_offset" or (effect in GEARS and place == ("all",)):
        return 0.0  # what all gears have in common counts for each of them
    return found[effect, place, one.deviation.component]

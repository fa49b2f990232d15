"""The figures that show where on the feet a gap lies."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shoecal_core.diagnosis.result import Diagnosis, Evidence, Fitted
from shoecal_core.report import palette
from shoecal_core.report.diagnosis_figures import AFTER, BEFORE
from shoecal_core.report.diagnosis_places import (
    accounted_for,
    cop_noise,
    field_between,
    field_under,
    stands,
)
from shoecal_core.report.figures import residual_field
from shoecal_core.report.figures.feet import foot_shape
from shoecal_core.report.figures.named_bars import percent
from shoecal_core.report.figures.residual_field import (
    SoleOutline,
    field_under_feet,
    magnification,
)
from shoecal_core.report.page import Picture
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import Shoe

FloatArray = NDArray[np.float64]


def place_pictures(
    diagnosis: Diagnosis, evidence: Evidence, robot: Robot, shoe: Shoe
) -> tuple[Picture, ...]:
    """Residuals on the feet, before and after."""
    every = np.ones(len(evidence.time), dtype=bool)
    alone = evidence.explained is None
    pairs = [("" if alone else ", nothing added", evidence.without, BEFORE)]
    if evidence.explained is not None:
        pairs.append((", with what was found", evidence.explained, AFTER))
    supports = [stands(evidence, int(run)) for run in np.unique(evidence.run)]
    known = [one for one in dict.fromkeys(supports) if one is not None]
    fields = [field_between(evidence, fitted, every) for _, fitted, _ in pairs]
    times = magnification(fields, cop_noise(evidence))
    pictures = []
    for (label, _, look), one in zip(pairs, fields, strict=True):
        if not known or not len(one.places):
            continue
        left = foot_shape(robot, shoe, 0)
        rights = [foot_shape(robot, shoe, 1, support) for support in known]
        pictures.append(
            Picture(
                f"CoP error between the feet{label}",
                residual_field.field_between(left, rights, one, look, times),
                "Each arrow starts where the model has the CoP and points to where the shoes "
                "measured it. Look for arrows that all point one way or grow towards one place: "
                "noise alone leaves short ones in all directions."
                + (" Thin outlines: other places of the right foot." if len(known) > 1 else ""),
            )
        )
    return (*pictures, *_under_feet(diagnosis, evidence, robot, shoe, pairs))


def _under_feet(
    diagnosis: Diagnosis,
    evidence: Evidence,
    robot: Robot,
    shoe: Shoe,
    pairs: list[tuple[str, Fitted, palette.Look]],
) -> list[Picture]:
    every = np.ones(len(evidence.time), dtype=bool)
    fields = [
        [field_under(evidence, fitted, every, foot) for foot in (0, 1)] for _, fitted, _ in pairs
    ]
    times = magnification([one for both in fields for one in both], cop_noise(evidence))
    shares, meaning = _cell_shares(diagnosis), "its share of the gap"
    if not shares:
        shares, meaning = (
            _accounted_for(evidence, shoe),
            "what one wrong force there could account for",
        )
    forces = np.concatenate([one.force for both in fields for one in both])
    largest = float(np.abs(forces).max()) if len(forces) else 0.0
    pictures = []
    for (label, _, look), both in zip(pairs, fields, strict=True):
        soles = [
            SoleOutline(foot_shape(robot, shoe, foot), both[foot],
                 _at_cells(shoe, foot, shares) if label == pairs[0][0] else ())
            for foot in (0, 1)
        ]  # fmt: skip
        numbers = f" Per cent at a cell: {meaning}." if any(one.shares for one in soles) else ""
        pictures.append(
            Picture(
                f"Error by where each foot was loaded{label}",
                field_under_feet(soles, look, times, largest),
                "Arrows and circles stand where the foot's own CoP was, and show how far the CoP "
                "and GRF of both feet together were off then. Where circles grow, look at the "
                f"cells that carry the load there.{numbers}",
            )
        )
    return pictures


def _cell_shares(diagnosis: Diagnosis) -> dict[str, float]:
    shares: dict[str, float] = {}
    for place in diagnosis.where:
        if place.cell:
            shares[place.cell] = shares.get(place.cell, 0.0) + place.share
    return shares


def _accounted_for(evidence: Evidence, shoe: Shoe) -> dict[str, float]:
    """Of every cell; nothing of six-axis sensors, which separate force and moments."""
    shares = {
        channel.name: accounted_for(evidence, evidence.without, channel.foot, channel.position)
        for channel in shoe.channels
        if not shoe.torque[shoe.of_foot(channel.foot)].any()
    }
    return {name: share for name, share in shares.items() if np.isfinite(share)}


def _at_cells(
    shoe: Shoe, foot: int, shares: dict[str, float]
) -> tuple[tuple[FloatArray, str], ...]:
    """Text at each place of a channel that holds a share; axes of one sensor are one place."""
    places: dict[tuple[float, ...], float] = {}
    for channel in shoe.channels:
        if channel.foot == foot and channel.name in shares:
            key = tuple(map(float, channel.position))
            places[key] = places.get(key, 0.0) + shares[channel.name]
    return tuple((np.array(place), percent(share)) for place, share in places.items())

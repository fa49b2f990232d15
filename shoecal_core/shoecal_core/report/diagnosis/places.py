"""Where on the feet a gap lies: residuals brought to the soles, and their figures."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.diagnosis.result import Diagnosis, Evidence, Fitted
from shoecal_core.report.figures.feet import foot_shape
from shoecal_core.report.figures.residual_field import (
    Field,
    FieldPanel,
    magnification,
    residual_fields,
)
from shoecal_core.report.page import Picture
from shoecal_core.report.palette import AFTER, BEFORE, Look
from shoecal_core.report.quantities import percent
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import FEET, Shoe

LEAST_EXCESS = 0.2
"""Excess over noise, as a part of it, from which it is worth asking who makes it."""
CELL_M = 0.008
"""Side of the squares over which arrows are averaged [m]."""
LEAST_SAMPLES = 3
"""Fewer in a square are noise."""


def signal(evidence: Evidence, fitted: Fitted, name: str) -> FloatArray:
    """(T,) residual of one signal, in its unit; NaN throughout where it was not there."""
    if name not in evidence.signals:
        return np.full(len(evidence.time), np.nan)
    values: FloatArray = fitted.residuals[:, evidence.signals.index(name)]
    return values if values.any() else np.full_like(values, np.nan)


def noise_of(evidence: Evidence, name: str) -> float:
    """Standard deviation of a signal's noise; NaN where it was not there."""
    if name not in evidence.signals:
        return float("nan")
    return float(evidence.noise[evidence.signals.index(name)])


def cop_residual(evidence: Evidence, fitted: Fitted) -> FloatArray:
    """(T, 2) CoP residual in the frame of the stance [m]."""
    return np.column_stack([signal(evidence, fitted, name) for name in ("cop_x", "cop_y")])


def cop_noise(evidence: Evidence) -> float:
    """Standard deviation of the noise of the CoP's place [m]; NaN where it was not there."""
    return float(np.hypot(noise_of(evidence, "cop_x"), noise_of(evidence, "cop_y")))


def stands(evidence: Evidence, run: int) -> DoubleSupport | None:
    """Where the right foot stands in a run; None where it is not known."""
    both = (evidence.run == run) & np.isfinite(evidence.support).all(axis=1)
    standing = both & evidence.loaded.all(axis=1)
    rows = standing if standing.any() else both
    if not rows.any():
        return None
    return DoubleSupport(*(float(value) for value in np.median(evidence.support[rows], axis=0)))


def in_sole(evidence: Evidence, values: FloatArray, foot: int, *, vectors: bool) -> FloatArray:
    """Points or vectors (T, 2) [m] from the frame of the stance to one foot's sole frame.

    NaN where the other foot's place is not known.
    """
    brought = np.full_like(values, np.nan)
    frame = np.where(evidence.loaded[:, 0], 0, 1)
    brought[frame == foot] = values[frame == foot]
    for run in np.unique(evidence.run):
        support = stands(evidence, int(run))
        rows = (evidence.run == run) & (frame != foot)
        if support is None or not rows.any():
            continue
        if vectors:
            support = DoubleSupport(0.0, 0.0, support.dtheta)
        turn = support.left_to_right if foot else support.right_to_left
        brought[rows] = turn(values[rows])
    return brought


def mean_field(places: FloatArray, arrows: FloatArray, force: FloatArray) -> Field:
    """Means over the squares of a grid in which there are enough samples.

    Args:
        places: (T, 2) of the samples [m].
        arrows: (T, 2) CoP residual [m].
        force: (T,) GRF residual [N].
    """
    known = np.isfinite(np.column_stack((places, arrows, force))).all(axis=1)
    places, arrows, force = places[known], arrows[known], force[known]
    if not len(places):
        return Field(places, arrows, force)
    squares = np.floor(places / CELL_M).astype(np.int64)
    _, owner, count = np.unique(squares, axis=0, return_inverse=True, return_counts=True)
    owner = owner.ravel()
    enough = count >= LEAST_SAMPLES

    def mean(values: FloatArray) -> FloatArray:
        """(k,) means of values (T,)."""
        means: FloatArray = np.bincount(owner, values)[enough] / count[enough]
        return means

    return Field(
        np.column_stack([mean(places[:, axis]) for axis in (0, 1)]),
        np.column_stack([mean(arrows[:, axis]) for axis in (0, 1)]),
        mean(force),
    )


def field_of(evidence: Evidence, fitted: Fitted, foot: int | None = None) -> Field:
    """Residual of both feet together over the CoP.

    Args:
        evidence, fitted: whose residual.
        foot: over the CoP of this foot, in its sole frame; None: over that of both feet together,
            as modelled, in the left sole's frame.
    """
    frame = foot or 0
    places = (
        in_sole(evidence, evidence.cop, frame, vectors=False)
        if foot is None
        else evidence.foot_cop[:, foot]
    )
    arrows = in_sole(evidence, cop_residual(evidence, fitted), frame, vectors=True)
    return mean_field(places, arrows, signal(evidence, fitted, "grf"))


def accounted_for(evidence: Evidence, fitted: Fitted, foot: int, place: FloatArray) -> float:
    """How much of the excess of GRF and CoP one force of any course at a place would account for.

    Of each sample's residual the part is taken that such a force can make; what noise alone
    would give is taken off. NaN where there is no clear excess.

    Args:
        place: (2,) in the foot's sole frame [m].
    """
    noise = np.array([noise_of(evidence, name) for name in ("grf", "cop_x", "cop_y")])
    off = in_sole(evidence, cop_residual(evidence, fitted), foot, vectors=True)
    arm = place - in_sole(evidence, evidence.cop, foot, vectors=False)
    whole = np.nansum(evidence.foot_force, axis=1)
    seen = np.column_stack((signal(evidence, fitted, "grf"), off)) / noise
    with np.errstate(divide="ignore", invalid="ignore"):
        way = np.column_stack((np.ones(len(arm)), arm / whole[:, None])) / noise
    known = np.isfinite(seen).all(axis=1) & np.isfinite(way).all(axis=1)
    seen, way = seen[known], way[known]
    excess = float((seen**2).sum()) - seen.size
    if excess < LEAST_EXCESS * max(seen.size, 1):
        return float("nan")
    made = ((seen * way).sum(axis=1) ** 2 / (way**2).sum(axis=1)).sum() - len(seen)
    return float(np.clip(made / excess, 0.0, 1.0))


def place_pictures(
    diagnosis: Diagnosis, evidence: Evidence, robot: Robot, shoe: Shoe
) -> tuple[Picture, ...]:
    """Residuals on the feet, before and after."""
    fits = [("" if evidence.explained is None else ", nothing added", evidence.without, BEFORE)]
    if evidence.explained is not None:
        fits.append((", with what was found", evidence.explained, AFTER))
    return (
        *_between_feet(evidence, robot, shoe, fits),
        *_under_feet(diagnosis, evidence, robot, shoe, fits),
    )


def _between_feet(
    evidence: Evidence, robot: Robot, shoe: Shoe, fits: Sequence[tuple[str, Fitted, Look]]
) -> list[Picture]:
    supports = [stands(evidence, int(run)) for run in np.unique(evidence.run)]
    known = [one for one in dict.fromkeys(supports) if one is not None]
    fields = [field_of(evidence, fitted) for _, fitted, _ in fits]
    if not known or not any(len(one.places) for one in fields):
        return []
    left = foot_shape(robot, shoe, 0)
    right, *others = [foot_shape(robot, shoe, 1, support) for support in known]
    thin = [foot.outline for foot in others]
    times = magnification(fields, cop_noise(evidence))
    return [
        Picture(
            f"CoP error between the feet{label}",
            residual_fields(
                [FieldPanel((right, left), one, "both feet together", thin)], look, times
            ),
            "Each arrow starts where the model has the CoP and points to where the shoes "
            "measured it. Look for arrows that all point one way or grow towards one place: "
            "noise alone leaves short ones in all directions."
            + (" Thin outlines: other places of the right foot." if thin else ""),
        )
        for (label, _, look), one in zip(fits, fields, strict=True)
    ]


def _under_feet(
    diagnosis: Diagnosis,
    evidence: Evidence,
    robot: Robot,
    shoe: Shoe,
    fits: Sequence[tuple[str, Fitted, Look]],
) -> list[Picture]:
    fields = [[field_of(evidence, fitted, foot) for foot in (0, 1)] for _, fitted, _ in fits]
    every = [one for both in fields for one in both]
    times = magnification(every, cop_noise(evidence))
    largest = max((float(np.abs(one.force).max()) for one in every if len(one.force)), default=0.0)
    shares, meaning = _cell_shares(diagnosis), "its share of the gap"
    if not shares:
        shares = _accounted_for(evidence, shoe)
        meaning = "what one wrong force there could account for"
    pictures = []
    for (label, fitted, look), both in zip(fits, fields, strict=True):
        shown = shares if fitted is evidence.without else {}
        panels = [
            FieldPanel((foot_shape(robot, shoe, foot),), one, f"{FEET[foot]} foot",
                       shares=_at_cells(shoe, foot, shown))
            for foot, one in enumerate(both)
        ]  # fmt: skip
        pictures.append(
            Picture(
                f"Error by where each foot was loaded{label}",
                residual_fields(panels, look, times, largest),
                "Arrows and circles stand where the foot's own CoP was, and show how far the CoP "
                "and GRF of both feet together were off then. Where circles grow, look at the "
                "cells that carry the load there."
                + (f" Per cent at a cell: {meaning}." if shown else ""),
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

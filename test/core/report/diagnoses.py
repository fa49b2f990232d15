"""Diagnoses made up from a cell that is not straight: what reports on them are tried with."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from core.estimation import synthetic
from core.shoe import shoes
from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.diagnosis.result import (
    Action,
    BudgetShare,
    Cause,
    Diagnosis,
    Evidence,
    Fitted,
    Gap,
    NamedHypothesis,
    NextMotion,
    Shrink,
    SimulatedShrink,
    Size,
    Where,
)
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import (
    at_cop,
    columns_in_left,
    cop,
    foot_wrenches,
)

CELL = "left/front_left"
QUADRATIC = 2e-2
"""1/N; what is wrong with the cell."""
SIGNALS = (
    "grf", "cop_x", "cop_y", "parity_left", "parity_right", "closure_x", "closure_y", "closure_yaw",
)  # fmt: skip
NOISE = np.array([0.12, 3e-4, 3e-4, 0.15, 0.15, 2e-4, 2e-4, 1e-3])
WEIGHT = 54.0
RATE = 10.0
UNLOADED = {5: 0, 6: 1}
"""The foot that is lifted in a run for a moment."""
TRAIN, TEST = (1, 2, 3, 4, 5, 6), (7, 8)


def evidence(shoe: Shoe | None = None, *, count: int = 300, empty: bool = False) -> Evidence:
    """Eight runs of a robot on shoes, one cell of which reads more the more it carries.

    Args:
        shoe: worn; None: the NAO's.
        count: samples a run.
        empty: nothing is wrong but noise.
    """
    shoe = shoes.shoe("nao_shoe") if shoe is None else shoe
    rng = np.random.default_rng(5)
    runs = [_run(shoe, number, count, rng) for number in (*TRAIN, *TEST)]
    run, time, loaded, support, places, forces = (
        np.concatenate(parts) for parts in zip(*runs, strict=True)
    )
    bad = 0 if empty else QUADRATIC
    index = shoe.names.index(CELL) if CELL in shoe.names else 0
    noise = np.concatenate([_noise(count, rng) for _ in runs])
    bend = np.zeros_like(forces)
    bend[:, index] = forces[:, index] ** 2
    raw = noise + bad * signals_of(shoe, bend, places, support)
    test = np.isin(run, TEST)
    lag = np.zeros_like(forces)
    lag[:, index] = np.gradient(forces[:, index]) * RATE
    high = np.zeros_like(forces)
    high[:, index] = np.maximum(forces[:, index] - 12.0, 0.0)
    drift = np.zeros_like(forces)
    drift[:, index] = np.arange(len(forces)) / len(forces) * 5.0
    fits = {
        "nothing": _fit(shoe, raw, forces, places, support, ~test, None),
        f"nonlinearity ({CELL})": _fit(shoe, raw, forces, places, support, ~test, bend),
        f"saturation ({CELL})": _fit(shoe, raw, forces, places, support, ~test, high),
        f"zero_drift ({CELL})": _fit(shoe, raw, forces, places, support, ~test, drift),
        f"hysteresis ({CELL})": _fit(shoe, raw, forces, places, support, ~test, lag),
    }
    fitted = [Fitted(label, *found) for label, found in fits.items()]
    hung = ~loaded[:, 0]
    fitted = [
        replace(
            one,
            residuals=_in_stance(one.residuals, hung, support),
            contribution=_in_stance(one.contribution, hung, support),
        )
        for one in fitted
    ]
    places = _turned(places, hung, support, vectors=False)
    wrenches = foot_wrenches(shoe, forces)
    foot_cop = np.where(loaded[..., None], cop(wrenches, 1.0), np.nan)
    return Evidence(
        signals=SIGNALS, run=run, time=time, test=test, loaded=loaded, support=support,
        cop=places, foot_cop=foot_cop, foot_force=wrenches[..., 0], outputs=forces, noise=NOISE,
        without=fitted[0], explained=None if empty else fitted[1],
        rivals=() if empty else tuple(fitted[1:]),
    )  # fmt: skip


def diagnosis(
    found: Evidence | None = None, verdict: str = "explained", **changes: object
) -> Diagnosis:
    """One with everything in it."""
    first = cause("nonlinearity", "load_cell", (CELL,), 0.93, quadratic=(4.1e-3, "1/N"))
    whole = Diagnosis(
        verdict=verdict,  # type: ignore[arg-type]
        gap=Gap(cop_mae_mm=1.42, grf_mae_n=0.41, cop_floor_mm=0.38, grf_floor_n=0.10),
        where=(
            Where("cop_y", "left", CELL, None, None, None, None, 0.46),
            Where("grf", "left", CELL, None, None, None, None, 0.31),
            Where("cop_x", "left", None, None, 3, "both feet", 12.4, 0.14),
            Where("closure", None, None, "LAnkleRoll", None, None, None, 0.03),
        ),
        causes=(first,),
        ambiguity=(NamedHypothesis("nonlinearity", (CELL,), 0.93),),
        ranking=(
            NamedHypothesis("nonlinearity", (CELL,), 0.93),
            NamedHypothesis("saturation", (CELL,), 0.04),
            NamedHypothesis("zero_drift", (CELL,), 0.02),
            NamedHypothesis("hysteresis", (CELL,), 0.004),
        ),
        cannot_detect=("span_drift (left): no temperature was recorded",
                       "inertia: all motions were slow"),
        cannot_separate=(
            ("crosstalk (left/front_left, left/front_right)", "cell_position (left/front_right)"),
            ("foot_placement (left)", "soft_ground (left)"),
        ),
        next_motion=NextMotion("hold", ("nonlinearity (left/front_left)",
                                        "hysteresis (left/front_left)")),
        train=TRAIN, test=TEST,
        notes=("no /imu in the recording: tilt of the floor was not looked at",),
        robot="nao", shoe="nao_shoe", evidence=found,
        action=Action("exchange the cell left/front_left", (1.42, 0.45)),
        budget=(
            BudgetShare("nonlinearity", (CELL,), 0.72, (0.6, 0.84)),
            BudgetShare("joint_compliance", ("all",), 0.2, (0.1, 0.3)),
            BudgetShare("not explained", (), 0.08, (0.02, 0.14)),
        ),
        dissent=("test run 8 gets worse with it: CoP 0.58 -> 1.10 mm",),
    )  # fmt: skip
    return replace(whole, **changes)  # type: ignore[arg-type]


def cause(
    effect: str,
    group: str,
    location: tuple[str, ...],
    probability: float,
    *,
    run: int | None = None,
    simulated: bool = True,
    **size: tuple[float, str],
) -> Cause:
    """A cause whose sizes are known to a tenth."""
    return Cause(
        effect=effect, group=group, location=location, probability=probability,
        size={
            name: Size(value, unit, tuple(sorted((0.9 * value, 1.1 * value))))  # type: ignore[arg-type]
            for name, (value, unit) in size.items()
        },
        run=run,
        shrink=Shrink(0.94, (0.88, 0.97), (1.42, 0.45), (0.41, 0.13)),
        hidden_cop_mm=0.8,
        simulated=SimulatedShrink(0.81, (1.61, 0.72), (0.44, 0.20))
        if simulated else None,
    )  # fmt: skip


def signals_of(
    shoe: Shoe, extra: FloatArray, places: FloatArray, support: FloatArray
) -> FloatArray:
    """(T, s) what forces (T, n) too many in the cells add to the signals, in first order."""
    signals = np.zeros((len(extra), len(SIGNALS)))
    for place in np.unique(support, axis=0):
        rows = (support == place).all(axis=1)
        more = extra[rows] @ columns_in_left(shoe, DoubleSupport(*map(float, place)))
        x, y = places[rows].T
        signals[rows, 0] = more[:, 0]
        signals[rows, 1] = (-more[:, 2] - x * more[:, 0]) / WEIGHT
        signals[rows, 2] = (more[:, 1] - y * more[:, 0]) / WEIGHT
    for foot in (0, 1):
        own = np.flatnonzero(shoe.foot == foot)[:4]
        signs = np.array([1.0, -1.0, -1.0, 1.0])[: len(own)]
        signals[:, 3 + foot] = extra[:, own] @ signs
    return signals


def in_left(found: Evidence) -> FloatArray:
    """(T, 2) modelled CoP in the left sole's frame [m], whichever foot stands."""
    places = found.cop.copy()
    for index in np.flatnonzero(~found.loaded[:, 0]):
        stood = DoubleSupport(*map(float, found.support[index]))
        places[index] = stood.right_to_left(found.cop[index])
    return places


def told_in_stance(signals: FloatArray, found: Evidence) -> FloatArray:
    """(T, s) signals of the left sole's frame in the frame of the stance."""
    return _in_stance(signals, ~found.loaded[:, 0], found.support)


def _in_stance(signals: FloatArray, hung: BoolArray, support: FloatArray) -> FloatArray:
    turned = signals.copy()
    turned[:, 1:3] = _turned(signals[:, 1:3], hung, support, vectors=True)
    return turned


def _turned(
    values: FloatArray, hung: BoolArray, support: FloatArray, *, vectors: bool
) -> FloatArray:
    """Points or vectors (T, 2) of the left sole's frame, in the right one's where left hangs."""
    turned = values.copy()
    for index in np.flatnonzero(hung):
        x, y, yaw = map(float, support[index])
        stood = DoubleSupport(0.0, 0.0, yaw) if vectors else DoubleSupport(x, y, yaw)
        turned[index] = stood.left_to_right(values[index])
    return turned


def _run(
    shoe: Shoe, number: int, count: int, rng: np.random.Generator
) -> tuple[IntArray, FloatArray, BoolArray, FloatArray, FloatArray, FloatArray]:
    """The CoP goes round between the feet; in some runs one foot is lifted for a moment."""
    stood = synthetic.SUPPORTS[number % len(synthetic.SUPPORTS)]
    time = np.arange(count) / RATE
    phase = 2.0 * np.pi * time / time[-1] * (-1.0 if number % 2 else 1.0) + rng.uniform(0.0, 6.0)
    middle = np.array([0.025, 0.0]) + stood.translation / 2.0
    across = stood.translation / np.linalg.norm(stood.translation)
    places = (
        middle + 0.05 * np.sin(phase)[:, None] * across
        + np.column_stack((0.03 * np.cos(2.0 * phase), np.zeros(count)))
    )  # fmt: skip
    loaded = np.ones((count, 2), dtype=bool)
    columns = columns_in_left(shoe, stood)
    forces = at_cop(np.full(count, WEIGHT), places) @ np.linalg.pinv(columns)
    if number in UNLOADED:
        lifted = slice(2 * count // 5, 3 * count // 5)
        foot = UNLOADED[number]
        loaded[lifted, foot] = False
        stands = np.array([0.03, 0.0]) + 0.01 * np.column_stack((np.cos(phase), np.sin(phase)))
        places[lifted] = (stood.right_to_left(stands) if foot == 0 else stands)[lifted]
        carrying = np.where((shoe.foot != foot)[:, None], columns, 0.0)
        forces[lifted] = (at_cop(np.full(count, WEIGHT), places) @ np.linalg.pinv(carrying))[lifted]
    support = np.tile([stood.dx, stood.dy, stood.dtheta], (count, 1))
    return np.full(count, number), time, loaded, support, places, forces


def _noise(count: int, rng: np.random.Generator) -> FloatArray:
    """(count, s) correlated in time."""
    white = rng.standard_normal((count, len(SIGNALS)))
    values = np.empty_like(white)
    values[0] = white[0]
    for index in range(1, count):
        values[index] = 0.6 * values[index - 1] + 0.8 * white[index]
    noise: FloatArray = values * NOISE
    return noise


def _fit(
    shoe: Shoe,
    raw: FloatArray,
    forces: FloatArray,
    places: FloatArray,
    support: FloatArray,
    train: BoolArray,
    effect: FloatArray | None,
) -> tuple[FloatArray, FloatArray]:
    """Residuals after gains, offsets and the effect were fitted, and what the effect adds."""
    patterns = [] if effect is None else [signals_of(shoe, effect, places, support)]
    for index in range(len(shoe.names)):
        for values in (forces[:, index], np.ones(len(forces))):
            extra = np.zeros_like(forces)
            extra[:, index] = values
            patterns.append(signals_of(shoe, extra, places, support))
    matrix = np.stack(patterns, axis=-1) / NOISE[:, None]
    wanted = raw / NOISE
    size, *_ = np.linalg.lstsq(
        matrix[train].reshape(-1, len(patterns)), wanted[train].ravel(), rcond=1e-9
    )
    contribution = np.zeros_like(raw) if effect is None else size[0] * patterns[0]
    return (wanted - matrix @ size) * NOISE, contribution

"""Faults of cells, cables and clocks, put into the readings of recorded runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from fault_draws import Draw, Expected, Injected, NoFaultError
from shoecal_core.arrays import FloatArray
from shoecal_core.recording.run import Run
from shoecal_core.screening.faults import Fault

NEWTONS_PER_VOLT = 12.0
"""Of a cell of nominal gain."""
LEAST_CUT_N = 0.4
"""Typically cut off by a saturated cell; less is nothing to a calibration."""


def dead(draw: Draw) -> Injected:
    """One cell gives one number all the time, or nothing but noise."""
    cell, rng = draw.cell(), draw.rng
    level = float(rng.choice([0.0, rng.uniform(-2.0, 2.0)]))
    noise = float(rng.choice([0.0, 0.001, 0.005]))
    runs = draw.with_channel(
        cell, lambda values, _: level + noise * rng.standard_normal(len(values))
    )
    return Injected(runs, Expected((Fault.DEAD,), words=(f"{draw.name(cell)} does not answer",)))


def stuck(draw: Draw) -> Injected:
    """From some moment on one cell stays where it is, with or without noise, to the end."""
    cell, rng = draw.cell(), draw.rng
    first = draw.run()
    share = rng.uniform(0.1, 0.7)
    noise = float(rng.choice([0.0, 0.001]))

    def change(values: FloatArray, run: int) -> FloatArray:
        if run < first:
            return values
        start = round(share * len(values)) if run == first else 0
        level = last[0] if run > first else values[start]
        last[0] = level
        still = level + noise * rng.standard_normal(len(values))
        return np.where(np.arange(len(values)) < start, values, still)

    last = [0.0]
    words = (f"{draw.name(cell)} is stuck", f"run {first} from")
    return Injected(draw.with_channel(cell, change), Expected((Fault.STUCK,), words=words))


def saturated(draw: Draw) -> Injected:
    """One cell goes no further than a level that it passes in 3 to 30 % of the session."""
    cell, rng = draw.cell(), draw.rng
    everything = np.concatenate([run.readings.value[:, cell] for run in draw.runs.values()])
    share = rng.uniform(0.03, 0.3)
    top = bool(rng.integers(2))
    level = float(np.quantile(everything, 1.0 - share if top else share))
    noise = float(rng.choice([0.0, 0.001]))

    def change(values: FloatArray, run: int) -> FloatArray:
        del run
        over = values > level if top else values < level
        return np.where(over, level + noise * rng.standard_normal(len(values)), values)

    over = np.abs(everything - level)[everything > level if top else everything < level]
    size = NEWTONS_PER_VOLT * float(np.median(over))
    # What is cut off must be more than nothing to a calibration.
    if size < LEAST_CUT_N:
        raise NoFaultError(f"only {size:.2f} N are cut off")
    # At the end of little load it looks like a cell that its screw preloads, and is called so.
    loaded = top == (draw.shoe.polarity[cell] > 0)
    said = "is saturated" if loaded else "does not answer to low load"
    return Injected(
        draw.with_channel(cell, change),
        Expected((Fault.SATURATED,), words=(f"{draw.name(cell)} {said}",)),
    )


def inverted(draw: Draw) -> Injected:
    """The signal wires of one cell are exchanged."""
    cell = draw.cell()
    runs = draw.with_channel(cell, lambda values, _: -values)
    return Injected(runs, Expected((Fault.INVERTED,), words=(f"{draw.name(cell)} is inverted",)))


def swapped(draw: Draw) -> Injected:
    """Two cells, of one foot or both, are connected at each other's place."""
    one, other = sorted(draw.rng.choice(len(draw.shoe.names), 2, replace=False).tolist())
    order = np.arange(len(draw.shoe.names))
    order[[one, other]] = other, one
    runs = {
        number: with_values(run, run.readings.value[:, order]) for number, run in draw.runs.items()
    }
    words = (draw.name(one), draw.name(other), "are swapped")
    return Injected(runs, Expected((Fault.SWAPPED,), words=words))


def spikes(draw: Draw) -> Injected:
    """One cell of one run gives 3 to 60 spikes of one to three samples, 1 N to its whole range."""
    cell, rng, number = draw.cell(), draw.rng, draw.run()
    run = draw.runs[number]
    values = run.readings.value.copy()
    starts = rng.choice(len(values) // 20 - 2, int(rng.integers(3, 61)), replace=False) * 20 + 20
    hit = np.zeros(len(values), dtype=bool)
    for start in starts:
        length = int(rng.integers(1, 4))
        size = rng.choice([-1.0, 1.0]) * np.exp(rng.uniform(np.log(draw.least_spike), np.log(60.0)))
        values[start : start + length, cell] += size / NEWTONS_PER_VOLT
        hit[start : start + length] = True
    times = run.readings.time[hit]
    return Injected(
        {number: with_values(run, values)},
        Expected(
            (Fault.SPIKE,),
            words=(draw.name(cell), "gave spikes", f"run {number}"),
            run=number,
            times=times,
        ),
    )


def late(draw: Draw) -> Injected:
    """The readings of all runs are stamped 20 to 150 ms late or early."""
    offset = float(draw.rng.choice([-1.0, 1.0]) * draw.rng.uniform(0.02, 0.15))
    runs = {}
    for number, run in draw.runs.items():
        time = run.readings.time + offset
        runs[number] = replace(run, readings=replace(run.readings, time=time))
    return Injected(runs, Expected((Fault.LATE,), words=(), time_offset=-offset))


def with_values(run: Run, values: FloatArray) -> Run:
    """The run with other readings."""
    return replace(run, readings=replace(run.readings, value=values))


CABLES: Mapping[str, Callable[[Draw], Injected]] = {
    "dead cell": dead,
    "stuck cell": stuck,
    "saturated cell": saturated,
    "inverted cell": inverted,
    "swapped cells": swapped,
    "outliers": spikes,
    "time offset": late,
}

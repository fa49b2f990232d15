"""Screening of runs in double support by statics and the model of the body."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

import numpy as np

from shoecal_core.arrays import BoolArray
from shoecal_core.samples.aligned import Aligned
from shoecal_core.samples.lifting import TRANSIT_S, LiftedFoot
from shoecal_core.samples.stretches import widened
from shoecal_core.screening.blocks import blocks
from shoecal_core.screening.cells.bending import Bending, bending, describe_bending
from shoecal_core.screening.cells.changed_gains import changed_gains, describe_changed_gains
from shoecal_core.screening.cells.drifting import describe_drift, drifting
from shoecal_core.screening.cells.hum import describe_hum, find_hum
from shoecal_core.screening.cells.leaking import describe_leaking, leaking
from shoecal_core.screening.cells.planes import changed_plane, describe_changed_plane
from shoecal_core.screening.cells.saturated import (
    Saturated,
    describe_saturated,
    flat,
    saturated,
    within_range,
)
from shoecal_core.screening.cells.turned_places import describe_turned_places, turned_places
from shoecal_core.screening.cells.wandering import describe_wandering, wandering
from shoecal_core.screening.cells.wiring import check_wiring, describe_wiring
from shoecal_core.screening.cells.zeros import (
    all_start_at_zero,
    describe_starts,
    describe_zeros,
    moved_zeros,
)
from shoecal_core.screening.events import Watch, first_slips, leave_out_marked, leave_out_run
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.loads.hanging import both_hang, without
from shoecal_core.screening.loads.pulled import describe_pulls, describe_wavering, pulls, wavering
from shoecal_core.screening.loads.unexplained import describe_unexplained, unexplained
from shoecal_core.screening.loads.weights import describe_weights, wrong_weights
from shoecal_core.screening.pose.closure import describe_slips
from shoecal_core.screening.result import Screening
from shoecal_core.screening.rough_fit import Statics, reweighed, solve
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.screening.six_axis.sideways import (
    describe_sideways,
    sideways_fault,
    sideways_pulls,
)
from shoecal_core.screening.six_axis.turned_frames import describe_turned_frames, turned_frames
from shoecal_core.screening.verdict import Finding
from shoecal_core.shoe.shoe import Shoe

SPOILS_SHARE = 0.2
"""Of the time, that a channel is at an end at least, before it spoils what other faults show: those
that are there for less are looked for when runs under another weight are known."""


def screen_standing(
    found: Screening,
    aligned: Mapping[int, Aligned],
    lifting: Mapping[int, LiftedFoot | None],
    fast: Collection[int],
    starts: Mapping[int, float],
    shoe: Shoe,
    weight: float,
    settings: CalibrationSettings,
) -> Screening:
    """What was found so far, and what is found in these runs.

    Args:
        aligned: runs in double support, by number.
        starts: of each of them, by one clock [s].
        lifting: of each of them, the foot that it lifts on purpose.
        fast: those of a fast motion, which disturbs them without any fault.
        weight: of robot and shoes [N].
    """
    hanging = both_hang(aligned, shoe, weight, settings)
    aloft = {run: widened(one, aligned[run].time, TRANSIT_S) for run, one in hanging.items()}
    parts = {
        run: blocks(within_range(shoe, without(one, hanging.get(run))), shoe)
        for run, one in aligned.items()
    }
    statics = Statics.of(shoe, parts, weight, settings)
    watched = {run for run, lift in lifting.items() if lift is None} - {*fast, *hanging}
    at_end = flat(shoe, parts)
    early = _flat(statics, at_end)
    bent = bending(statics)
    if not found.adding(early).fails:  # else gains and cables seem to be wrong
        early = _varying(statics, watched, bent)
    found = found.adding(early)
    if not found.fails and len(aligned) > 1:
        height = float(np.median([np.median(one.states.com[:, 0, 2]) for one in aligned.values()]))
        found = found.adding(_electrical(statics, height, starts))
    steady = {run: aligned[run] for run, lift in lifting.items() if lift is None}
    if not found.fails:
        slow = {run: one for run, one in steady.items() if run not in fast}
        found = found.adding(describe_sideways(sideways_fault(shoe, slow, weight)))
    if found.fails:
        return found
    pushed = sideways_pulls(shoe, steady, weight) + pulls(statics, watched)
    pulled = {one.run: one for one in pushed}
    sound = statics.without(pulled)
    wrong = wrong_weights(sound)
    # Neither a pull nor a load is let in, which bend the gains of all runs; with gains of a single
    # run, a pull on the other one looks like a cell at its end.
    unloaded = sound.without({one.run for one in wrong})
    fitted = unloaded if unloaded.parts else statics
    checked = sound if any(one.undecided for one in pulled.values()) else statics
    ended = _ended(fitted, checked, at_end)
    found = found.adding(describe_saturated(shoe, ended))
    if found.fails:
        return found
    found = found.adding(describe_pulls(list(pulled.values())) + describe_weights(wrong, weight))
    if found.fails:
        return found
    drifts = any(one.fault is Fault.DRIFTING for one in found.findings)
    found = found.adding(_minor(fitted, watched, bent, drifts=drifts))
    fitting = [run for run in parts if run in unloaded.parts or run in pulled]
    watch = Watch(shoe, fitted.fit.parameters, weight, settings, ended)
    found = replace(found, load={run: watch.load(one) for run, one in aligned.items()})
    events = {
        run: watch.events(aligned[run], parts[run], lifting[run], aloft.get(run), pulled.get(run))
        for run in fitting
    }
    found = replace(found, hanging={run: one for run, one in hanging.items() if run in fitting})
    slipped = first_slips(events)
    found = found.adding(describe_slips(slipped))
    for run, one in aligned.items():
        if run in events:
            slip = slipped.get(run)
            found = leave_out_marked(found, run, one, events[run], slip, shoe, fast=run in fast)
        else:
            found = leave_out_run(found, run, one)
    return found


def _ended(fitted: Statics, checked: Statics, at_end: Mapping[int, BoolArray]) -> list[Saturated]:
    """Channels with an end in the runs that are checked, by gains of those that are fitted.

    Args:
        at_end: (B,) blocks of each run that say nothing of the gains, see `flat`.
    """
    going = {
        run: one.part(~at_end[run]) for run, one in fitted.rows.items() if not at_end[run].all()
    }
    fit = solve(reweighed(going, fitted.information), fitted.information)
    missing = {run: checked.force_error(run, fit.vector) for run in checked.parts}
    return saturated(checked.parts, missing, fit.parameters, checked.settings)


def _flat(statics: Statics, at_end: Mapping[int, BoolArray]) -> list[Finding]:
    """Channels that have an end, where one stays there while its neighbours go on."""
    if not any(one.any() for one in at_end.values()):
        return []
    found = _ended(statics, statics, at_end)
    return describe_saturated(statics.shoe, [one for one in found if one.share > SPOILS_SHARE])


def _varying(statics: Statics, watched: Collection[int], bent: Bending | None) -> list[Finding]:
    """What lets the vertical force vary by much in most runs: bent cells, cables, or a hand."""
    wavers = wavering(statics, watched)
    if wavers is None:
        return []
    if bent is not None:
        return describe_bending(statics.shoe, bent, refused=True)
    wiring = check_wiring(statics)
    if wiring.clear:
        return describe_wiring(statics.shoe, wiring)
    return describe_turned_places(turned_places(statics)) or describe_wavering(wavers)


def _minor(
    statics: Statics, watched: Collection[int], bent: Bending | None, *, drifts: bool
) -> list[Finding]:
    """What a calibration copes with; left to the last, as all else is likelier.

    A drift that was found explains what it makes of the force.
    """
    known = describe_hum(find_hum(statics, watched)) + describe_bending(statics.shoe, bent)
    if all_start_at_zero(statics.parts):
        known += describe_starts(statics.shoe)
    known = known or describe_changed_plane(changed_plane(statics))
    return known or ([] if drifts else describe_unexplained(unexplained(statics)))


def _electrical(statics: Statics, height: float, starts: Mapping[int, float]) -> list[Finding]:
    """The first fault of zeros, gains, cables and converter that is found.

    Their order is a decision: each of them looks like some of those that come after it.

    Args:
        height: of the CoM over the floor [m].
        starts: of each run, by one clock [s].
    """
    shoe = statics.shoe
    moved = moved_zeros(statics, height)
    if moved is not None:
        return describe_zeros(shoe, moved, statics.weight)
    if shoe.torque.any() and all_start_at_zero(statics.parts):
        return describe_starts(shoe)
    drift, wanders = drifting(statics, starts), wandering(statics)
    # One cell that wanders makes zeros drift, at its foot alone.
    if drift is not None and (wanders is None or drift.readings or drift.feet[1:]):
        return describe_drift(drift, statics.weight)
    if wanders is not None:
        return describe_wandering(shoe, wanders)
    changed = changed_gains(statics)
    if changed is not None:
        return describe_changed_gains(shoe, changed)
    wiring = check_wiring(statics)
    turned = None if wiring.fits else turned_places(statics)
    return (
        describe_turned_places(turned)
        or describe_wiring(shoe, wiring)
        or describe_leaking(shoe, leaking(statics))
        or describe_turned_frames(turned_frames(statics))
    )

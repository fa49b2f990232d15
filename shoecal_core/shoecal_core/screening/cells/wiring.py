"""Cables: cells that are wired upside down, and cells that are connected at each other's place.

Signs come from a fit that asks for none. The feet's sideways forces nearly cancel, and what is left
of them is of the size of the model's errors: the fit shows that two sideways axes contradict each
other, not which of them is inverted. Exchanged cells are found by trying: for every pair the
equations are solved again with the two at each other's place, and the one exchange that makes the
readings fit much better than all else is named.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import combinations, product

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.rough_fit import RoughFit, Statics, solve_sums
from shoecal_core.screening.verdict import Finding
from shoecal_core.shoe.shoe import FEET, Shoe

_QUARTER = (
    "its frame were turned by 90 degrees about z, and then fx and fy are exchanged and one of them "
    "is reversed, too"
)
_TURNED: Mapping[tuple[bool, tuple[str, ...]], str] = {
    (True, ("mx",)): _QUARTER,
    (True, ("my",)): _QUARTER,
    (False, ("mx", "my")): (
        "its frame were turned by 180 degrees about z, and then fx and fy are reversed, too"
    ),
    (False, ("fz", "my")): "its z pointed down, turned about x, and then fy is reversed, too",
    (False, ("fz", "mx")): "its z pointed down, turned about y, and then fx is reversed, too",
    (False, ("fz", "mx", "my")): (
        "it gave what the foot presses on the floor instead of what the floor presses on the "
        "foot, and then fx and fy are reversed, too"
    ),
}
"""What is inverted, and whether the moments are swapped, where the whole frame is turned."""
SURE_STDS = 5.0
"""A gain has its sign when it is this many standard deviations off zero."""
BETTER = 25.0
"""An exchange counts when it lowers the sum of squares by this much, in units of the mean square
of what the best one leaves, or of the settings' where that is more."""
CLEAR_SHARE = 0.2
"""Of the sum of squares, that the exchange of a whole foot leaves at most: a force from outside,
which fits no cables, is also less off with some of them, and leaves 0.6 of it."""
FITS = 1.0
"""Mean square of what the right cables leave at most, in units of the settings' variances: sound
recordings leave 0.03 to 0.07, noisy real ones 0.8, a rope 2.3."""


@dataclass(frozen=True)
class WiringFaults:
    """What is wrong with the cables.

    Attributes:
        inverted: channels whose sign is against the shoe file.
        swapped: pairs of channels that are connected at each other's place.
        contradicting: left and right sideways axes of which one is inverted.
        clear: the exchange leaves a small part of what does not fit as the cables should be.
        fits: whether the readings fit the robot with these faults put right.
    """

    inverted: tuple[int, ...]
    swapped: tuple[tuple[int, int], ...]
    contradicting: tuple[tuple[int, int], ...] = ()
    clear: bool = field(default=False, compare=False)
    fits: bool = field(default=True, compare=False)


def check_wiring(statics: Statics) -> WiringFaults:
    """Compare the cables as they should be with every exchange of two cells, or of both feet.

    A single bad run may fit a wrong exchange better: what is found must hold without any one of
    the runs, too.
    """
    shoe = statics.shoe
    right = np.arange(len(shoe.names))
    places = [right, *(exchanged(right, pairs) for pairs in exchanges(shoe))]
    tried = [_without_each(statics, place) for place in places]
    best = int(np.argmin([one.fits[0].cost for one in tried]))
    clear = tried[best].fits[0].cost < CLEAR_SHARE * tried[0].fits[0].cost
    against, there = (_inverted(statics, places[at], tried[at]) for at in (0, best))
    # What is upside down where it should be, and is not elsewhere, belongs there.
    turned = against.any() and not there.any()
    if _better(tried[best], tried[0], least=0.0 if turned else BETTER):
        against = there
    else:
        best = 0
    return WiringFaults(
        inverted=tuple(np.flatnonzero(against).tolist()),
        swapped=tuple((int(k), int(places[best][k])) for k in np.flatnonzero(places[best] > right)),
        contradicting=_contradicting(statics, tried[best]),
        clear=clear,
        fits=clear or tried[best].fits[0].cost < FITS * tried[best].count[0],
    )


@dataclass(frozen=True)
class _Tried:
    """Fits to all runs, then to all but each of them; `count` blocks that each one had."""

    fits: list[RoughFit]
    count: list[float]


def _without_each(statics: Statics, place: IntArray) -> _Tried:
    """Fits with the channels at other places (n,)."""
    there = statics.changed(lambda one: replace(one, columns=one.columns[place]))
    sums = [one.sums() for one in there.rows.values()]
    subsets = [sums] + [sums[:index] + sums[index + 1 :] for index in range(len(sums))]
    return _Tried(
        [solve_sums(subset, statics.information) for subset in subsets],
        [sum(one.count for one in subset) for subset in subsets],
    )


def _inverted(statics: Statics, place: IntArray, tried: _Tried) -> BoolArray:
    """(n,) channels of the other sign in every fit; of sideways axes it is not known.

    One that moves the CoP of half the weight by less than the model knows it is not judged.
    """
    shoe = statics.shoe
    signs = [_against(shoe.polarity[place], fit) for fit in tried.fits]
    gain, lever = tried.fits[0].parameters.gain, np.linalg.norm(shoe.columns[place, 1:], axis=1)
    judged = shoe.vertical[place] | _moves(statics, gain, lever)
    return np.asarray(np.all(signs, axis=0) & judged & ~_sideways(shoe)[place])


def _sideways(shoe: Shoe) -> BoolArray:
    """(n,) channels of forces along the sole."""
    return np.asarray(~shoe.vertical & ~shoe.torque)


def _moves(statics: Statics, gain: FloatArray, lever: FloatArray) -> BoolArray:
    """(n,) channels that move the CoP by more than it is known, by gains and levers (n,) [m]."""
    readings = np.concatenate([one.readings for one in statics.parts.values()])
    moment = 2.0 * np.abs(gain) * readings.std(axis=0) * lever
    return np.asarray(moment / (0.5 * statics.weight) > statics.settings.cop_std_m)


def _contradicting(statics: Statics, tried: _Tried) -> tuple[tuple[int, int], ...]:
    """Sideways axes of both feet: if one is right, the other has the wrong sign in every fit."""
    shoe = statics.shoe
    gain = shoe.polarity * np.array([abs(one.nominal_gain or 1.0) for one in shoe.channels])
    judged = _moves(statics, gain, np.linalg.norm(shoe.columns[:, 1:], axis=1)) & _sideways(shoe)
    return tuple(
        (one, twin)
        for one, twin in of_feet(shoe)
        if judged[one] and judged[twin] and all(_apart(one, twin, gain, fit) for fit in tried.fits)
    )


def _apart(one: int, twin: int, gain: FloatArray, fit: RoughFit) -> bool:
    """Whether one's sign is surely wrong where its twin has its gain of (n,)."""
    follows = fit.covariance[one, twin] / fit.covariance[twin, twin]
    given = fit.vector[one] + follows * (gain[twin] - fit.vector[twin])
    variance = fit.covariance[one, one] - follows * fit.covariance[one, twin]
    return bool(np.sign(gain[one]) * given < -SURE_STDS * np.sqrt(max(variance, 0.0)))


def _better(one: _Tried, other: _Tried, least: float) -> bool:
    """Whether one fits better than another by so much, with and without any of the runs."""
    return all(
        there.cost - here.cost > least * max(1.0, here.cost / count) * count / one.count[0]
        for here, there, count in zip(one.fits, other.fits, one.count, strict=True)
    )


def exchanged(order: IntArray, pairs: list[tuple[int, int]]) -> IntArray:
    """(n,) the order (n,) with these pairs of places exchanged."""
    changed = order.copy()
    for one, other in pairs:
        changed[[one, other]] = order[[other, one]]
    return changed


def _against(polarity: IntArray, fit: RoughFit) -> BoolArray:
    """(n,) gains that surely have the other sign."""
    gain = fit.parameters.gain
    std = np.sqrt(np.diag(fit.covariance))[: len(gain)]
    against: BoolArray = polarity * gain < -SURE_STDS * std
    return against


def exchanges(shoe: Shoe) -> list[list[tuple[int, int]]]:
    """Pairs of one-axis cells; two pairs of one foot, or the same pair or pairs of both, as cells
    are listed from another end; of torques, and of the vertical force with a torque, of one foot
    and of both; all channels of both feet where these are alike, by name or by their place in
    mirrored soles.
    """
    cells = [i for i, channel in enumerate(shoe.channels) if channel.column[0] == 1.0]
    torques = [i for i in range(len(shoe.names)) if shoe.torque[i]]
    turned = [pair for pair in combinations(torques, 2) if _of_one_foot(shoe, pair)]
    mixed = [pair for pair in product(cells, torques) if _of_one_foot(shoe, pair)]
    feet = of_feet(shoe)
    twin = dict(feet)
    return [
        *([pair] for pair in (*combinations(cells, 2), *turned, *mixed)),
        *_of_one_order(shoe, cells, twin),
        *([turned] if turned[1:] else []),
        *([(one, two), (twin[one], twin[two])] for one, two in mixed if one in twin),
        *([feet] if feet else []),
        *([pairs] if (pairs := mirrored(shoe)) not in ([], feet) else []),
    ]


def _of_one_order(
    shoe: Shoe, cells: list[int], twin: dict[int, int]
) -> list[list[tuple[int, int]]]:
    """Two pairs of one foot's cells, and one or two of both feet's: a whole list in another order,
    of a driver that counts from the heel, or of a board that is built in the other way round.
    """
    single = [pair for pair in combinations(cells, 2) if _of_one_foot(shoe, pair)]
    double = [
        list(pairs)
        for pairs in combinations(single, 2)
        if _of_one_foot(shoe, (pairs[0][0], pairs[1][0])) and not set(pairs[0]) & set(pairs[1])
    ]
    both = [
        [*pairs, *((twin[one], twin[other]) for one, other in pairs)]
        for pairs in ([[pair] for pair in single] + double)
        if all(one in twin for pair in pairs for one in pair)
    ]
    return double + both


def _of_one_foot(shoe: Shoe, pair: tuple[int, int]) -> bool:
    return bool(shoe.foot[pair[0]] == shoe.foot[pair[1]])


def mirrored(shoe: Shoe) -> list[tuple[int, int]]:
    """Each one-axis cell of the left foot with that at its place in the mirror; empty without."""
    left, right = (
        {
            tuple(np.round(channel.column[1:] * side, 3).tolist()): i
            for i, channel in enumerate(shoe.channels)
            if shoe.foot[i] == foot and channel.column[0] == 1.0
        }
        for foot, side in ((0, np.array([1.0, 1.0])), (1, np.array([-1.0, 1.0])))
    )
    return [(i, right[at]) for at, i in left.items()] if left.keys() == right.keys() else []


def of_feet(shoe: Shoe) -> list[tuple[int, int]]:
    """Each channel of the left foot with the one of that name on the right; empty without."""
    left, right = (
        {name.partition("/")[2]: i for i, name in enumerate(shoe.names) if shoe.foot[i] == foot}
        for foot in (0, 1)
    )
    return [(i, right[name]) for name, i in left.items()] if left.keys() == right.keys() else []


def describe_wiring(shoe: Shoe, wiring: WiringFaults) -> list[Finding]:
    """Cells upside down or at each other's place."""
    if not wiring.fits and (wiring.swapped or wiring.inverted):
        return [_describe_better(shoe, wiring)]
    if wiring.swapped and set(wiring.swapped) == set(of_feet(shoe)):
        return [
            Finding(
                "FAIL",
                "left and right are exchanged: what comes as one foot's fits the other; exchange "
                "their plugs, their topics, or feet.*.link in the robot file, and record again",
                Fault.SWAPPED,
            )
        ]
    if wiring.swapped and set(wiring.swapped) == set(mirrored(shoe)):
        return [
            Finding(
                "FAIL",
                "left and right are exchanged as in a mirror: what comes as one cell fits that at "
                "the same place of the other foot, seen from the middle; exchange the plugs or "
                "names of both feet cell by cell, and record again",
                Fault.SWAPPED,
            )
        ]
    frames = _turned_frames(shoe, wiring)
    known = {channel for _, channels in frames for channel in channels}
    findings = [Finding("FAIL", text, Fault.INVERTED) for text, _ in frames]
    findings += [
        Finding(
            "FAIL",
            f"{shoe.names[one]} and {shoe.names[other]} are swapped: what comes as one fits the "
            "other's place; exchange their cables, or their names at the driver, and record again",
            Fault.SWAPPED,
        )
        for one, other in wiring.swapped
        if one not in known
    ]
    findings += [
        Finding(
            "FAIL",
            f"{shoe.names[one]} and {shoe.names[twin]} contradict each other: one of the two is "
            "inverted, which of them is not known; push the standing robot along that axis: both "
            "must show a force against the push; exchange the signal wires of the one that does "
            "not, or turn its 'polarity' round",
            Fault.INVERTED,
        )
        for one, twin in wiring.contradicting
    ]
    return findings + [
        Finding(
            "FAIL",
            f"{shoe.names[channel]} is inverted: its sign is against the shoe file; exchange its "
            f"signal wires, or turn its 'polarity' round{_others(shoe, channel)}",
            Fault.INVERTED,
        )
        for channel in wiring.inverted
        if channel not in known
    ]


def _others(shoe: Shoe, channel: int) -> str:
    """What else is to be looked at where a force of a six-axis sensor is inverted."""
    foot, _, axis = shoe.names[channel].partition("/")
    sideways = [name for name in (f"{foot}/fx", f"{foot}/fy") if name in shoe.names]
    if axis != "fz" or not sideways:
        return ""
    return f"; push the standing robot along {' and '.join(sideways)}: they may be, too"


def _describe_better(shoe: Shoe, wiring: WiringFaults) -> Finding:
    """Cables with which readings fit better, not well: two faults, or a force from outside."""
    names = shoe.names
    pairs = [f"{names[one]} and {names[other]} exchanged" for one, other in wiring.swapped]
    listed = " and ".join([*pairs, *(f"{names[one]} inverted" for one in wiring.inverted)])
    return Finding(
        "FAIL",
        "no gains, zeros or cables make the readings fit the robot's weight and motion; with "
        f"{listed} they fit better, but not well: take off ropes and cables, do not touch the "
        "robot, and record again; where that is so already, check the channels' names and places",
        Fault.UNEXPLAINED,
    )


def _turned_frames(shoe: Shoe, wiring: WiringFaults) -> list[tuple[str, tuple[int, ...]]]:
    """Six-axis sensors of which several axes are wrong as in a frame that is turned as a whole.

    Each in words, with the channels that it explains. Sideways forces are not judged: of both feet
    turned alike they cancel, and who corrects only what was named leaves them wrong.
    """
    alike: dict[tuple[str, str], dict[str, tuple[int, ...]]] = {}
    for foot in FEET:
        axes = {axis: f"{foot}/{axis}" for axis in ("fz", "mx", "my")}
        if not set(axes.values()) <= set(shoe.names):
            continue
        at = {axis: shoe.index(name) for axis, name in axes.items()}
        swapped = (min(at["mx"], at["my"]), max(at["mx"], at["my"])) in wiring.swapped
        inverted = tuple(axis for axis, index in at.items() if index in wiring.inverted)
        how = _TURNED.get((swapped, inverted))
        if how is not None:
            wrong = sorted({*inverted, *(("mx", "my") if swapped else ())})
            channels = tuple(at[axis] for axis in wrong)
            alike.setdefault((", ".join(wrong), how), {})[foot] = channels
    found = list[tuple[str, tuple[int, ...]]]()
    for (listed, how), feet in alike.items():
        text = (
            f"several axes of the {' and '.join(feet)} foot's sensor are wrong ({listed}), as if "
            f"{how}; correct the sensor's frame at its driver, or names and 'polarity' of all its "
            "axes in the shoe file, and push the standing robot forward and to the left to see fx "
            "and fy"
        )
        found.append((text, tuple(one for channels in feet.values() for one in channels)))
    return found

"""What a diagnosis says, in words for somebody who never saw the software."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from shoecal_core.diagnosis.result import Cause, NamedHypothesis, Size, Where
from shoecal_core.error_sources.effects.words import name_of, words_of
from shoecal_core.report.quantities import SPACE, UNKNOWN, number, percent
from shoecal_core.shoe.shoe import FEET

SIGNALS: Mapping[str, str] = {
    "grf": "GRF",
    "cop_x": "CoP forward",
    "cop_y": "CoP sideways",
    "air": "forces on a lifted foot",
    "air_f": "force on a lifted foot",
    "air_mx": "moment about x on a lifted foot",
    "air_my": "moment about y on a lifted foot",
    "closure": "closure",
    "closure_x": "closure, forward",
    "closure_y": "closure, sideways",
    "closure_z": "closure, upward",
    "closure_roll": "closure, rotation about x",
    "closure_pitch": "closure, rotation about y",
    "closure_yaw": "closure, rotation about z",
    "parity": "rigid-plate parity",
    "parity_left": "rigid-plate parity, left",
    "parity_right": "rigid-plate parity, right",
    "tilt": "tilt of the body",
    "tilt_x": "tilt of the body about x",
    "tilt_y": "tilt of the body about y",
}

MOTIONS: Mapping[str, str] = {
    "landmarks": "move the CoP from landmark to landmark, counter-clockwise",
    "reversed": "move the CoP from landmark to landmark the other way round",
    "faster": "move the CoP from landmark to landmark 1.8 times as fast",
    "faster_reversed": "move the CoP from landmark to landmark the other way, 1.8 times as fast",
    "hold": "stand still for a while at each landmark",
    "unload_left": "lift the left foot a little, for a moment",
    "unload_right": "lift the right foot a little, for a moment",
    "torso_tilt": "lean the torso forward, back, left and right",
    "torso_height": "move from landmark to landmark with the torso lower",
    "yawed_stance": "stand with the feet turned against each other",
    "wide_stance": "stand with the feet far apart",
    "left_foot_ahead": "stand with the left foot ahead",
    "right_foot_ahead": "stand with the right foot ahead",
    "turn_180": "turn the whole robot by 180 degrees and repeat a run",
    "warm_up": "wait until everything is warm and repeat a run",
    "known_weight": "put a known weight on the robot and repeat a run",
}

REASONS: Mapping[frozenset[str], str] = {
    frozenset({"crosstalk", "cell_position"}): (
        "a share of another cell's force moves the CoP exactly as that cell standing elsewhere"
    ),
    frozenset({"foot_placement", "soft_ground"}): (
        "both shift a foot's CoP in proportion to how it is loaded"
    ),
    frozenset({"floor_tilt", "joint_offset"}): (
        "a leaning floor and an ankle that reads a wrong angle lean the body alike"
    ),
    frozenset({"latency", "low_pass"}): (
        "at slow motion a filter is nothing but a delay; faster motion parts them"
    ),
    frozenset({"foot_placement", "cell_position"}): (
        "a turned foot moves its cells sideways; each can hide the other"
    ),
    frozenset({"zero_drift", "span_drift"}): (
        "under a nearly constant load a drift of zero and one of gain are the same"
    ),
    frozenset({"link_com", "payload"}): (
        "both move the whole centre of mass; only other postures part them"
    ),
    frozenset({"creep", "hysteresis"}): (
        "without standing still, what lags with time and what lags with load look alike"
    ),
}
"""Why two effects cannot be separated, by the two."""
ALIKE = "in the motions of this session both leave the same trace in every signal"

_JOINTS = {"joint_offset", "joint_compliance", "backlash"}
_LINKS = {"payload", "link_com"}
_EVERYWHERE = dict.fromkeys(_JOINTS, "all joints of the legs") | {"total_mass": "whole robot"}
_EACH = dict.fromkeys(_JOINTS, "each leg joint") | {"total_mass": "the robot"}
_SHOWN: Mapping[str, tuple[float, str]] = {
    "m": (1e3, "mm"),
    "rad": (180.0 / math.pi, "°"),
    "s": (1.0, "s"),
    "": (100.0, "%"),
    "rad/(N m)": (180.0 / math.pi, "°/(N m)"),
}
"""By the unit of a size: factor and unit for a person."""
_PLAIN_FACTOR = {"inertia"}


def signal_text(signal: str) -> str:
    """What a signal is."""
    return SIGNALS.get(signal, signal.replace("_", " "))


def place_text(effect: str, location: Sequence[str]) -> str:
    """Where it sits, with the word for it; empty where it has no place."""
    if not location:
        return ""
    if tuple(location) == ("all",):
        return _EVERYWHERE.get(effect, "both feet")
    cells = [name for name in location if "/" in name]
    if len(cells) == len(location):
        if effect == "crosstalk" and len(cells) == 2:
            return f"cell {cells[0]} shows {cells[1]}"
        return f"cell{'s' if len(cells) > 1 else ''} {' and '.join(cells)}"
    if set(location) <= set(FEET):
        return f"{' and '.join(location)} foot"
    word = "joint" if effect in _JOINTS else "link" if effect in _LINKS else ""
    return f"{word} {', '.join(location)}".strip()


def hypothesis_text(one: NamedHypothesis | Cause) -> str:
    """Name and place, short."""
    place = place_text(one.effect, one.location)
    return f"{name_of(one.effect)} ({place})" if place else name_of(one.effect)


def finding_text(cause: Cause) -> str:
    """Place, effect and probability: `left/front_left bends with load (96 %)`."""
    return f"{state_text(cause)} ({percent(cause.probability)})"


def state_text(cause: Cause) -> str:
    """Place and effect: `left/front_left bends with load`."""
    places = [f"{name} foot" if name in FEET else name for name in cause.location]
    if not places:
        where = "the robot"
    elif places == ["all"]:
        where = _EACH.get(cause.effect, "each foot")
    else:
        where = places[0] if len(places) == 1 else f"each of {listed(places)}"
    if cause.effect == "crosstalk" and len(places) == 2:
        where = places[0]
    run = "" if cause.run is None else f" in run {cause.run}"
    return f"{where} {words_of(cause.effect).state}{run}"


def label_text(label: str) -> str:
    """The same of a label as hypotheses bear it: `effect (place, place)`, several with `and`."""
    return " and ".join(_one_label(part) for part in label.split(" and "))


def _one_label(label: str) -> str:
    effect, mark, rest = label.partition(" (")
    location = tuple(part.strip() for part in rest.removesuffix(")").split(",")) if mark else ()
    return hypothesis_text(NamedHypothesis(effect, location, 0.0))


def effect_of(label: str) -> str:
    """The effect's identifier in a label."""
    return label.partition(" (")[0].strip()


def size_text(effect: str, size: Size) -> str:
    """Value with its 95 % interval, in units for a person."""
    factor, unit = _SHOWN.get(size.unit, (1.0, size.unit))
    if effect in _PLAIN_FACTOR and not size.unit:
        factor, unit = 1.0, ""
    largest = max(abs(size.value), *map(abs, size.ci95)) * factor
    if unit == "s" and 0.0 < largest < 1.0:
        factor, unit, largest = 1e3, "ms", 1e3 * largest
    value, low, high = (_rounded(factor * one, largest) for one in (size.value, *size.ci95))
    after = f"{'' if unit == '°' else SPACE}{unit}" if unit else ""
    return f"{value}{after} (95{SPACE}%: {low} to {high})"


def sizes_text(cause: Cause) -> str:
    """All components of its size; empty for an effect without one."""
    return ", ".join(f"{name} {size_text(cause.effect, size)}" for name, size in cause.size.items())


def where_text(place: Where) -> str:
    """A place in signal, body and time."""
    parts = [signal_text(place.signal)]
    if place.cell:
        parts.append(f"at cell {place.cell}")
    elif place.foot:
        parts.append(f"at the {place.foot} foot" if place.foot in FEET else f"at {place.foot}")
    if place.joint:
        parts.append(f"at joint {place.joint}")
    if place.run is not None:
        parts.append(f"in run {place.run}")
    if place.phase:
        parts.append(f"({place.phase.replace('_', ' ')})")
    if place.onset_s is not None:
        parts.append(f"from {number(place.onset_s, 1)} s on")
    return " ".join(parts)


def why_alike(labels: Sequence[str]) -> str:
    """Why hypotheses cannot be separated, by the effects in them."""
    effects = frozenset(effect_of(label) for label in labels)
    found = [reason for pair, reason in REASONS.items() if pair <= effects]
    if found:
        return "; ".join(found)
    if len(effects) == 1:
        return "the same effect at places that these motions load alike"
    return ALIKE


def motion_text(motion: str) -> str:
    """What to do."""
    return MOTIONS.get(motion, motion.replace("_", " "))


def _rounded(value: float, largest: float) -> str:
    """To three digits of the largest of a kind."""
    if not math.isfinite(value) or not math.isfinite(largest):
        return UNKNOWN
    if largest == 0.0:
        return "0"
    decimals = max(0, 2 - math.floor(math.log10(largest)))
    if decimals <= 6:
        return number(value, decimals)
    mantissa, exponent = f"{value:.2e}".split("e")
    power = str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return f"{mantissa.replace('-', chr(0x2212))}·10{power}"


def listed(names: Sequence[str], last: str = "and") -> str:
    """`a, b and c`."""
    if len(names) < 2:
        return "".join(names)
    return f"{', '.join(names[:-1])} {last} {names[-1]}"

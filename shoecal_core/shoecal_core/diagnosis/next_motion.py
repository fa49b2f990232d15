"""The run that separates what is confused, by the physics of each pair of effects."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from shoecal_core.diagnosis.possible_motions import WARM, YAWED
from shoecal_core.diagnosis.result import NamedHypothesis, NextMotion
from shoecal_core.error_sources.effects.contact import TURNED
from shoecal_core.samples.known_weight import WEIGHTED
from shoecal_core.shoe.shoe import FEET

UNLOADED = "unload_"
"""With the foot that one of the two is at: in the air it shows its zeros, and no more."""
BODY = frozenset({"joint_offset", "link_com", "payload", "total_mass"})
ZEROS = frozenset({"zero_drift", "zero_offset"})
GAINS = frozenset({"span_drift", "nonlinearity", "saturation", "crosstalk"})
GEOMETRY = frozenset({"foot_placement", "cell_position"})
SEPARATED_BY: Sequence[tuple[frozenset[str], frozenset[str], str]] = (
    # A delay grows with the frequency without end, a lag does not.
    (frozenset({"latency"}), frozenset({"low_pass", "creep", "hysteresis"}), "faster"),
    (frozenset({"low_pass"}), frozenset({"creep", "hysteresis"}), "faster"),
    # Memory fades while nothing moves.
    (frozenset({"creep"}), frozenset({"hysteresis", "zero_drift", "span_drift"}), "hold"),
    # The floor stays, the robot turns.
    (frozenset({"floor_tilt"}), BODY | GEOMETRY, TURNED),
    (ZEROS, GAINS | GEOMETRY | {"off_axis_load"}, UNLOADED),
    (frozenset({"off_axis_load"}), GAINS, UNLOADED),
    # What is known to be added shows what one newton is.
    (frozenset({"total_mass", "payload"}), GAINS | ZEROS, WEIGHTED),
    (frozenset({"zero_drift"}), frozenset({"zero_offset"}), WARM),
    # Another yaw between the feet turns an error of the shoes, not one of the body.
    (frozenset({"foot_placement"}), frozenset({"cell_position", "soft_ground"}), YAWED),
    (GEOMETRY, BODY, YAWED),
    # Masses draw the CoP by where they are, joints by how they lean.
    (frozenset({"link_com", "payload"}), frozenset({"joint_offset"}), "torso_tilt"),
    (frozenset({"joint_compliance"}), frozenset({"backlash", "soft_ground"}), "torso_height"),
    (frozenset({"backlash"}), frozenset({"joint_offset", "hysteresis"}), "reversed"),
)
"""Effects, those that a motion separates from them, and the motion."""


def propose(confused: Sequence[NamedHypothesis]) -> NextMotion | None:
    """The motion that separates the most of what is probable, by pairs of it.

    Returns:
        None where less than two are confused, or no motion separates them: exact twins are never
        separated.
    """
    worth: dict[str, float] = {}
    separated: dict[str, dict[str, None]] = {}
    for at, one in enumerate(confused):
        for other in confused[:at]:
            for motion in _motions(other, one):
                worth[motion] = worth.get(motion, 0.0) + one.probability * other.probability
                separated.setdefault(motion, {}).update(dict.fromkeys((other.label, one.label)))
    if not worth:
        return None
    best = max(worth, key=lambda motion: worth[motion])
    return NextMotion(best, tuple(separated[best]))


def _motions(one: NamedHypothesis, other: NamedHypothesis) -> Iterator[str]:
    """The one that separates two effects, wherever they are."""
    for these, those, motion in SEPARATED_BY:
        if (one.effect in these and other.effect in those) or (
            other.effect in these and one.effect in those
        ):
            yield _foot(one, other) if motion == UNLOADED else motion
            return


def _foot(one: NamedHypothesis, other: NamedHypothesis) -> str:
    """The unloading of a foot that either is at; where both are at all, of the left one."""
    at = {place.partition("/")[0] for place in (*one.location, *other.location)}
    return UNLOADED + next((foot for foot in FEET if foot in at), FEET[0])

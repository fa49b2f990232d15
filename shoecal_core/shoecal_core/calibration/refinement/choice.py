"""Which of the found effects are fitted beside the tolerances.

A diagnosis judges by more signals than the GRF and CoP that a calibration fits: what it is sure of
is fitted. It does not know the tolerances, though, and what it is not sure of may be nothing but
these in another form; to fit that beside them takes away rather than adds. So every set of the
doubtful effects is tried on the training runs: an effect must raise the logarithm of their evidence
by STRONG, which pays for all the effects and places that the diagnosis went through to name it.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from shoecal_core.calibration.refinement.found_effects import FoundEffect
from shoecal_core.calibration.refinement.refine import Evidence

STRONG = 3.0
"""Logarithm of a Bayes factor from which evidence is called strong (Kass and Raftery, Journal of
the American Statistical Association 90, 1995: 773-795)."""


@dataclass(frozen=True)
class Tried:
    """A set of doubtful effects, and by how much it raises the logarithm of the evidence."""

    effects: tuple[FoundEffect, ...]
    gain: float


@dataclass(frozen=True)
class Choice:
    """What is fitted of that which was found.

    Attributes:
        fitted: effects.
        left_out: the others.
        tried: every set of doubtful effects, the smallest first; empty where there was no doubt.
    """

    fitted: tuple[FoundEffect, ...] = ()
    left_out: tuple[FoundEffect, ...] = ()
    tried: tuple[Tried, ...] = ()

    @property
    def told(self) -> str:
        """For a person to read, in one line; empty where nothing was found."""
        if not self.fitted and not self.left_out:
            return ""
        words = f"found effects that are fitted: {_listed(self.fitted)}"
        if self.left_out:
            words += f"; that are not: {_listed(self.left_out)}"
        if not self.tried:
            return words
        gains = ", ".join(f"{one.gain:+.1f} with {_listed(one.effects)}" for one in self.tried)
        return f"{words} (log evidence of the training runs: {gains}; {STRONG:g} each is strong)"

    def to_json(self) -> dict[str, object]:
        """By labels, with the figure of every set that was tried."""
        return {
            "fitted": [one.label for one in self.fitted],
            "left_out": [one.label for one in self.left_out],
            "tried": [
                {"effects": [effect.label for effect in one.effects], "log_evidence": one.gain}
                for one in self.tried
            ],
        }


def choose(
    effects: Sequence[FoundEffect],
    sure: Callable[[FoundEffect], bool],
    evidence: Callable[[Sequence[FoundEffect]], Evidence],
) -> Choice:
    """Try every set of the doubtful effects beside those that are sure.

    Residuals larger than expected are no news of an effect: the evidence then counts by a share.

    Args:
        effects: that can be fitted.
        sure: tells whether there is no doubt of one.
        evidence: of some of them, fitted beside the tolerances.
    """
    certain = [one for one in effects if sure(one)]
    doubtful = [one for one in effects if not sure(one)]
    if not doubtful:
        return Choice(fitted=tuple(certain))
    without = evidence(certain)
    tried = [Tried((), 0.0)]
    for size in range(1, len(doubtful) + 1):
        for some in itertools.combinations(doubtful, size):
            more = evidence([*certain, *some]).log - without.log
            tried.append(Tried(some, more / max(1.0, without.misfit)))
    best = max(tried, key=lambda one: one.gain - STRONG * len(one.effects)).effects
    return Choice(
        fitted=tuple(one for one in effects if one in certain or one in best),
        left_out=tuple(one for one in doubtful if one not in best),
        tried=tuple(tried[1:]),
    )


def _listed(effects: Sequence[FoundEffect]) -> str:
    return " and ".join(effect.label for effect in effects) or "none"

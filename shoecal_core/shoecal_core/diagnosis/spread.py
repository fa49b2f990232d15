"""What varies of each band of a signal beyond noise: its most probable variance.

Of what is left after a fit, each cosine coefficient of a signal has in its band a variance that is
known to a factor only. See `scoring` for what it is expected to be.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.diagnosis.rows import Rows
from shoecal_core.error_sources.signals import AIR, GRF, PARITY

COUNTS = 0.15
"""Of an independent coefficient, what one of a signal counts: signals are partly redundant,
motions repeat, and what a model lacks comes back with them."""
FREEDOM = 5.0
"""Degrees of freedom by which a band's variance is known beforehand."""
FORM_LEVELS = (1.0, 0.5, 0.25, 0.12)
"""Of each signal, factors on what tolerance errors add to it in another form; their logarithms have
a normal prior of unit deviation."""
WORSE_FORM_LEVELS = (3.0, 2.0, 1.4, *FORM_LEVELS)
"""The same of a robot that may be built worse than its tolerances say."""
MODEL_LEVELS = (1.0, 0.5, 0.25, 0.12)
"""Of what a model lacks in a signal, over the usual; with a log-normal prior of unit deviation."""
BODILESS = frozenset((GRF.start, *range(AIR.start, AIR.stop), *range(PARITY.start, PARITY.stop)))
"""Signals that hang on cells and weight alone: there the model may be far better than usual."""
UNMODELLED_LEVELS = (2.0, 4.0, 8.0, 16.0, 32.0, 64.0)
"""The same where an unmodelled term is there."""
UNMODELLED_COST = 1.0
"""Logarithm of probability that an unmodelled term costs in each signal that it is in."""


@dataclass(frozen=True)
class Spread:
    """Of each group (G,): see `Scored`; `variance` is the most probable one, all else is of another
    that was given.
    """

    variance: FloatArray
    expected: FloatArray
    form_level: FloatArray
    model_level: FloatArray
    log_likelihood: FloatArray


def spread_of(
    rows: Rows,
    power: FloatArray,
    lacking: FloatArray,
    variance: FloatArray,
    form_levels: tuple[float, ...],
    *,
    unmodelled: bool,
) -> Spread:
    """What each group most probably has, for sums of squares (G,).

    Of every signal forms are as far off as they usually are or less, and the model lacks as
    much as it usually does; where no body is in the model, perhaps less; where an unmodelled
    term is there, perhaps more.

    Args:
        rows: what is fitted. power: (G,) sums of squares of what is left.
        lacking: (G,) variance that the model usually lacks.
        variance: (G,) of which the likelihood is wanted.
        form_levels: of tolerance errors' forms, in signals that depend on the body.
        unmodelled: whether an unmodelled term is there.
    """
    found = Spread(*(np.empty_like(power) for _ in range(5)))
    for signal in np.unique(rows.signal):
        here = rows.signal == signal
        squares, count, most = power[here], rows.count[here], rows.most[here]
        models = MODEL_LEVELS if signal in BODILESS else MODEL_LEVELS[:1]
        beyond = UNMODELLED_LEVELS if unmodelled else ()
        # What gears, links and plates do in whatever form, they leave the weight as it is.
        forms = FORM_LEVELS if signal in BODILESS else form_levels
        form, model = _grid(forms, (*models, *beyond))
        usual = np.minimum(model, 1.0)
        expected = rows.noise[here] + form**2 * rows.form[here] + usual**2 * lacking[here]
        more = np.where(model > 1.0, model, 0.0)
        middle = expected + more**2 * rows.smooth[here]
        cost = np.where(model > 1.0, UNMODELLED_COST, 0.5 * np.log(usual) ** 2)
        cost = (cost + 0.5 * np.log(form) ** 2)[:, 0]
        free = most_probable(squares, middle, count, most)
        best = int(np.argmax(log_likelihood(free, squares, middle, count).sum(axis=1) - cost))
        found.variance[here] = free[best]
        likely = log_likelihood(variance[here], squares, middle, count)
        best = int(np.argmax(likely.sum(axis=1) - cost))
        found.expected[here] = expected[best]
        found.form_level[here], found.model_level[here] = form[best], usual[best]
        found.log_likelihood[here] = likely[best] - cost[best] / np.count_nonzero(here)
    return found


@cache
def _grid(forms: Sequence[float], models: Sequence[float]) -> tuple[FloatArray, FloatArray]:
    """(L, 1) each, of all pairs: levels of forms, and of what the model lacks."""
    pairs = np.array(list(itertools.product(forms, models)))
    return pairs[:, :1], pairs[:, 1:]


def most_probable(
    power: FloatArray, expected: FloatArray, count: FloatArray, most: FloatArray
) -> FloatArray:
    """(..., G) variances that groups most probably have.

    Args:
        power: (G,) sums of squares. expected: (..., G) variance. count: (G,) rows.
        most: (G,) by which the variance may be more.
    """
    free = (FREEDOM * expected + COUNTS * power) / (FREEDOM + COUNTS * count)
    found: FloatArray = np.clip(free, expected, expected + most)
    return found


def log_likelihood(
    variance: FloatArray, power: FloatArray, expected: FloatArray, count: FloatArray
) -> FloatArray:
    """(..., G) of groups at some variances, whose prior is included; see `most_probable`."""
    ratio = variance / expected
    likely = -0.5 * COUNTS * (count * np.log(variance) + power / variance)
    found: FloatArray = likely - 0.5 * FREEDOM * (np.log(ratio) + 1.0 / ratio - 1.0)
    return found

"""Is a calibration accurate enough? Errors in per cent of the weight and of a foot's half width.

Errors are counted against the model, and a walk's model is poor: it misses accelerations within a
step. How much of an error any calibration could win is seen from how far sensor and model move
together: what is left after GRF and CoP were scaled and shifted to fit the model best belongs to
the model (or to noise), whatever gains and offsets are.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.series import Errors, Mae, Series
from shoecal_core.robot.robot import Robot
from shoecal_core.screening.verdict import VERDICTS, Finding
from shoecal_core.shoe.shoe import FEET

GRF_WARN, GRF_FAIL = 0.02, 0.05
"""Mean absolute error of the GRF, over the weight."""
COP_WARN, COP_FAIL = 0.25, 0.5
"""The same of the CoP, over half the width of the narrower foot's sensing polygon."""
MODEL_SHARE = 0.5
"""The model is the limit where it leaves at least this share of the error."""
PROMISED = 3.0
"""Times that errors on the runs that were fitted may be what is expected of a calibration."""
_MEDIAN_SQUARE = 0.4549
"""Median of the square of a normal number of unit deviation."""
LEAST_SAMPLES = 100
"""Of one kind of stance from which the limit is taken."""


@dataclass(frozen=True)
class ModelLimit:
    """What no calibration can win against a walk's model.

    Attributes:
        grf: mean absolute error that the best linear map leaves [N].
        cop: the same of both feet together, of the left and of the right foot; NaN with too few
            samples [m].
        together: correlation of measured and modelled CoP within stances, likewise.
    """

    grf: float
    cop: tuple[float, float, float]
    together: tuple[float, float, float]

    def to_json(self) -> dict[str, float]:
        """For result files [N, mm]."""
        found = {"grf_mae_n": self.grf}
        for name, left, moved in zip(("", "left_", "right_"), self.cop, self.together, strict=True):
            if np.isfinite(left):
                found[f"{name}cop_mae_mm"] = 1e3 * left
                found[f"{name}cop_correlation"] = moved
        return found


def model_limit(pairs: Sequence[tuple[Series, Series]]) -> ModelLimit | None:
    """The limit over some stances, a pair each: measured and modelled.

    None where the robot stands, and with too few samples.
    """
    kinds: dict[int | None, list[tuple[Series, Series]]] = {0: [], 1: [], None: []}
    for ours, model in pairs:
        if np.ptp(model.grf) > 0.0:
            kinds[_standing(model)].append((ours, model))
    force, place, moved = [], {}, {}
    for kind, some in kinds.items():
        if sum(len(ours.grf) for ours, _ in some) < LEAST_SAMPLES:
            continue
        # What feet in the air read is known: the GRF may be scaled, but not shifted.
        shown, wanted = (np.concatenate([pair[side].grf for pair in some]) for side in (0, 1))
        force.append(np.abs(shown * (shown @ wanted) / (shown @ shown) - wanted))
        place[kind] = _left([(ours.cop, model.cop) for ours, model in some])
        moved[kind] = np.concatenate([_about_means(ours.cop, model.cop) for ours, model in some], 1)
    if not force:
        return None
    everything = [place.values(), *([place[foot]] if foot in place else [] for foot in (0, 1))]
    motions = [moved.values(), *([moved[foot]] if foot in moved else [] for foot in (0, 1))]
    both, left, right = (
        float(np.concatenate(list(some)).mean()) if some else np.nan for some in everything
    )
    return ModelLimit(
        float(np.concatenate(force).mean()),
        (both, left, right),
        (_correlation(motions[0]), _correlation(motions[1]), _correlation(motions[2])),
    )


@dataclass(frozen=True)
class Misfit:
    """What a fit leaves on its own runs, without the white noise of the readings.

    Attributes:
        grf: root mean square [N].
        cop: the same of the length of the CoP's error [m].
    """

    grf: float
    cop: float


def misfit(pairs: Sequence[tuple[Series, Series]]) -> Misfit:
    """Of some stances, a pair each: measured and modelled."""
    force = [(ours.grf - model.grf)[:, None] for ours, model in pairs]
    place = [ours.cop - model.cop for ours, model in pairs]
    return Misfit(_slow(force), _slow([one[np.isfinite(one).all(axis=1)] for one in place]))


def _slow(series: Sequence[FloatArray]) -> float:
    """Root mean square length of (T, k) each, less that of white noise on all of them.

    Noise shows in second differences, in which what a robot does from sample to sample cancels.
    """
    whole = np.concatenate(series)
    bends = np.concatenate([np.diff(one, n=2, axis=0) for one in series])
    if not len(bends):
        return 0.0
    noise = float(np.median(bends**2, axis=0).sum() / (6.0 * _MEDIAN_SQUARE))
    return float(np.sqrt(max(float((whole**2).sum(axis=1).mean()) - noise, 0.0)))


def check_promise(left: Misfit, expected: Misfit) -> list[Finding]:
    """A fit that leaves far more on its own runs than it promises of any other is none.

    Args:
        left: by the fit.
        expected: of both feet, by its covariance.
    """
    excesses = [
        f"{name} {scale * found:.3g} {unit} where {scale * promised:.3g} {unit} is expected"
        for name, found, promised, scale, unit in (
            ("GRF", left.grf, expected.grf, 1.0, "N"),
            ("CoP", left.cop, expected.cop, 1e3, "mm"),
        )
        if found > PROMISED * promised
    ]
    if not excesses:
        return []
    return [
        Finding(
            "FAIL",
            f"the fit contradicts its own runs: it leaves {' and '.join(excesses)} (RMS without "
            "noise); something else than gains and offsets is wrong: see what shoecal diagnose "
            "finds",
        )
    ]


def _standing(model: Series) -> int | None:
    """The foot that stands alone."""
    known = np.isfinite(model.foot_cop).any(axis=(0, 2))
    return int(known.argmax()) if known.any() else None


def _left(pairs: Sequence[tuple[FloatArray, FloatArray]]) -> FloatArray:
    """(T,) how far the first of (T, k) each is off the second, scaled and shifted axis by axis.

    No scale is negative: a sensor that moves against the model does not measure it.
    """
    shown, wanted = (np.concatenate([pair[side] for pair in pairs]) for side in (0, 1))
    shown, wanted = shown - shown.mean(axis=0), wanted - wanted.mean(axis=0)
    power = np.maximum((shown**2).sum(axis=0), 1e-300)
    scale = np.clip((shown * wanted).sum(axis=0) / power, 0.0, None)
    return np.asarray(np.linalg.norm(scale * shown - wanted, axis=1))


def _about_means(ours: FloatArray, model: FloatArray) -> FloatArray:
    """(2, K) both about their means, one axis after the other."""
    return np.stack([(one - one.mean(axis=0)).reshape(-1) for one in (ours, model)])


def _correlation(motions: Iterable[FloatArray]) -> float:
    parts = list(motions)
    if not parts:
        return float("nan")
    ours, model = np.concatenate(parts, axis=1)
    return float((ours * model).sum() / np.sqrt((ours**2).sum() * (model**2).sum()))


def check_accuracy(
    label: str,
    errors: Errors,
    robot: Robot,
    limit: ModelLimit | None = None,
    *,
    given: str = "",
) -> list[Finding]:
    """Errors of both feet together, and of each foot where they are known.

    Args:
        label: of the runs.
        errors: of measured against modelled GRF and CoP.
        robot: for its weight and its feet.
        limit: of the model; None for a robot that stands.
        given: name of a calibration that was not fitted here, so that it may be of other shoes.
    """
    cure = (
        "check the robot's weight, the shoe file, the noise of readings and that nothing touched "
        "the robot"
    )
    if given:
        cure = f"see that calibration '{given}' is of these shoes and unedited; else {cure}"
    width = min(foot.half_width for foot in robot.feet)
    place = (errors.cop, *errors.foot_cop)
    return [
        *_judged("GRF", label, (errors.grf, *errors.foot_grf), robot.weight, limit, cure),
        *_judged("CoP", label, place, width, limit, cure),
    ]


def _judged(
    name: str,
    label: str,
    found: Sequence[Mae],
    whole: float,
    limit: ModelLimit | None,
    cure: str,
) -> list[Finding]:
    """One finding on a quantity of both feet, the left and the right one."""
    force = name == "GRF"
    warn, fail = (GRF_WARN, GRF_FAIL) if force else (COP_WARN, COP_FAIL)
    scale, unit = (1.0, "N") if force else (1e3, "mm")
    left = (np.nan,) * 3 if limit is None else (limit.grf, *(np.nan,) * 2) if force else limit.cop
    level, limited, most = "PASS", True, warn
    for index, mae in enumerate(found):
        share = mae.mean / whole
        if share <= warn or (index > 0 and not mae.count):
            continue
        bounded = left[index] >= MODEL_SHARE * mae.mean
        worse = "WARN" if share <= fail or bounded else "FAIL"
        if not share <= fail:
            most = fail
        level = max(level, worse, key=VERDICTS.index)
        limited = limited and bounded
    if level == "PASS":
        return []
    each = [
        f"{foot} foot {scale * mae.mean:.2f} {unit}"
        for foot, mae in zip(FEET, found[1:], strict=True)
        if mae.count
    ]
    both = found[0].mean
    text = (
        f"{name} is {scale * both:.2f} {unit} off its model on {label} runs"
        f"{' (' + ', '.join(each) + ')' if each else ''}, {both / whole:.1%} of "
        f"{'the weight' if force else 'half the width of a foot'} (limit {most:.0%})"
    )
    if limited and limit is not None:
        text += (
            ": the model of the walk, not the sensor, is the limit: any calibration could win "
            f"{scale * max(both - left[0], 0.0):.2f} {unit} of it at most (within steps the CoP of "
            f"sensor and model move together with r = {limit.together[0]:.2f}); judge the sensor "
            "by slow motions in double support"
        )
    else:
        text += f": {cure}"
    return [Finding(level, text)]

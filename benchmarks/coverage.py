"""Do stated uncertainties hold? Over many simulated robots, and over repeats with one robot.

    .venv/bin/python benchmarks/coverage.py [--first 61] [--count 200] [--repeats 10]

Calibrates the sessions of a population (made where they do not stand yet), holds gains against
those drawn, GRF and CoP of runs kept for the test against contact forces, and writes a section of
docs/trust.md and the key `coverage` of out/trust.json. The default tolerances were chosen while
looking at seeds 1 to 60; the seeds measured here by default were not looked at before.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

import numpy as np
import yaml
from numpy.typing import NDArray

from pages import table, write_trust
from population import Member, different_robots, one_robot, sessions
from shoecal_core.calibration.assessment import NORMAL_95
from shoecal_core.calibration.evaluate import truth_series
from shoecal_core.calibration.pipeline import calibrate_session
from shoecal_core.recording.session import Session
from shoecal_core.recording.truth import read_truth
from shoecal_core.sensing.sensing import Sensing

FloatArray = NDArray[np.float64]
STEP = 100
"""Every so many samples of a test run: errors change slowly."""
WHAT = ("gain", "time offset", "GRF", "CoP", "left CoP", "right CoP")
LOWEST, HIGHEST = 0.90, 0.98


@dataclass(frozen=True)
class Held:
    """One calibration against the truth.

    Attributes:
        ratios: by quantity, errors over their standard deviations.
        gain: (n,) the gains found.
        gain_std: (n,) their standard deviations.
        expected, actual: root mean square CoP error of both feet, left, right [m].
    """

    ratios: dict[str, FloatArray]
    gain: FloatArray
    gain_std: FloatArray
    expected: FloatArray
    actual: FloatArray


def hold(member: Member) -> Held:
    """Calibrate one session and hold it against its truth; CoP corrections are left out."""
    session = Session.open(member.folder)
    outcome = calibrate_session(session, member.train, member.test)
    stages, found, data = outcome.stages, outcome.assessment, outcome.data
    parameters = stages.parameters
    drawn = yaml.safe_load((session.truth_path(1).parent / "reality.yaml").read_text())
    true_gain = np.array([drawn["gain"][name] for name in data.shoe.names])
    std = np.sqrt(np.diag(found.covariance))
    count = len(true_gain)
    ratios: dict[str, list[FloatArray]] = {name: [] for name in WHAT}
    ratios["gain"].append((parameters.gain - true_gain) / std[:count])
    ratios["time offset"].append(np.array([stages.time_offset / std[-1]]))
    errors = found.error_model
    sensing = Sensing(data.shoe, parameters)
    lengths: list[list[tuple[FloatArray, FloatArray]]] = [[], [], []]
    for stance in data.of(outcome.test):
        few = stance.part(slice(None, None, STEP))
        truth = read_truth(session.truth_path(stance.run), data.start_ns[stance.run])
        true = truth_series(truth, few)
        measured = sensing.measure(few.readings)
        outputs = parameters.outputs(few.readings)
        both = errors.both_feet(outputs, few.support)
        ratios["GRF"].append((measured.total_grf - true.grf) / both.grf)
        off = measured.combined_cop(few.support) - true.cop
        ratios["CoP"].append((off / both.cop).ravel())
        lengths[0].append((both.cop, off))
        for foot, name in enumerate(("left CoP", "right CoP")):
            spread, off = errors.foot(outputs, foot), measured.cop[:, foot] - true.foot_cop[:, foot]
            ratios[name].append((off / spread.cop).ravel())
            lengths[1 + foot].append((spread.cop, off))
    expected, actual = (
        np.array([_rms(np.concatenate([pair[side] for pair in pairs])) for pairs in lengths])
        for side in (0, 1)
    )
    joined = {name: np.concatenate(parts) for name, parts in ratios.items()}
    finite = {name: values[np.isfinite(values)] for name, values in joined.items()}
    return Held(finite, parameters.gain, std[:count], expected, actual)


def _rms(vectors: FloatArray) -> float:
    """Root mean square length of vectors (T, 2) [m]."""
    return float(np.sqrt(np.nanmean((vectors**2).sum(axis=1))))


def measure(members: Sequence[Member]) -> list[Held]:
    """All members, on all cores."""
    made = [member for member, _ in sessions(members)]
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(hold, made, chunksize=4))


def coverage(held: Sequence[Held]) -> dict[str, dict[str, float]]:
    """By quantity: share inside 95 % intervals with its own, and how long errors are in them."""
    figures = {}
    for name in WHAT:
        shares = np.array([np.mean(np.abs(one.ratios[name]) < NORMAL_95) for one in held])
        # The unit is the calibration: its samples err together.
        width = NORMAL_95 * float(shares.std(ddof=1)) / np.sqrt(len(shares))
        together = np.concatenate([one.ratios[name] for one in held])
        figures[name] = {
            "inside": float(shares.mean()),
            "inside_from": max(0.0, float(shares.mean()) - width),
            "inside_to": min(1.0, float(shares.mean()) + width),
            "rms_in_std": float(np.sqrt(np.mean(together**2))),
        }
    return figures


def repeats(held: Sequence[Held]) -> dict[str, float]:
    """How far gains of one robot's repeated calibrations differ, against what is stated."""
    gains, stds = (np.array([getattr(one, name) for one in held]) for name in ("gain", "gain_std"))
    first, second = np.triu_indices(len(held), 1)
    stated = np.sqrt(stds[first] ** 2 + stds[second] ** 2)
    ratios = np.abs(gains[first] - gains[second]) / stated
    return {
        "calibrations": len(held),
        "gain_spread": float(np.mean(gains.std(axis=0, ddof=1) / np.abs(gains.mean(axis=0)))),
        "stated_gain_std": float(np.mean(stds / np.abs(gains))),
        "inside": float(np.mean(ratios < NORMAL_95)),
        "rms_in_std": float(np.sqrt(np.mean(ratios**2))),
    }


def section(first: int, held: Sequence[Held], again: dict[str, float]) -> str:
    """The part of the page."""
    rows = [["95 % interval of", "holds in", "error, in stated standard deviations (RMS)"]]
    for name, found in coverage(held).items():
        span = f"{found['inside_from']:.1%} to {found['inside_to']:.1%}"
        rows.append([name, f"{found['inside']:.1%} ({span})", f"{found['rms_in_std']:.2f}"])
    expected, actual = (
        1e3 * np.median([getattr(one, name) for one in held], axis=0)
        for name in ("expected", "actual")
    )
    lengths = [["CoP error (RMS), median", "expected [mm]", "true [mm]"]]
    for index, name in enumerate(("both feet", "left", "right")):
        lengths.append([name, f"{expected[index]:.1f}", f"{actual[index]:.1f}"])
    return f"""\
## Stated uncertainties
`make coverage` (benchmarks/coverage.py): {len(held)} simulated robots of the default reality,
seeds {first} to {first + len(held) - 1}, each calibrated in three double supports; GRF and CoP on
two more, without CoP corrections, against contact forces. The share that should be inside is 95 %;
in brackets what {len(held)} calibrations tell of it. The default tolerances were chosen while
looking at seeds 1 to 60 only. Single offsets are not in the table: four cells of a foot leave one
pattern of them open that changes neither force nor CoP.

{table(rows)}

The aim is {LOWEST:.0%} to {HIGHEST:.0%}; outside it: {_outside(held)}.

{table(lengths)}

GRF holds more often than 95 %: the simulated scale is off by 0.19 N always, the robot file states
0.29 N. So does the time offset: it is zero in every simulated robot, where its prior expects it.
Gains hold a little too often: two errors that are always there, gears that give and plates that
carry load past the cells, partly cancel in them.

One robot calibrated {again["calibrations"]:.0f} times in other double supports: its gains spread
by {again["gain_spread"]:.1%}, stated are {again["stated_gain_std"]:.1%}; of all differences between
two of them {again["inside"]:.1%} are inside the 95 % interval of a difference. The stated
uncertainty is the larger one, as it holds what the model gets wrong in the same way each time.
"""


def _outside(held: Sequence[Held]) -> str:
    """Quantities whose intervals hold too seldom or too often."""
    found = coverage(held)
    wrong = [name for name in WHAT if not LOWEST <= found[name]["inside"] <= HIGHEST]
    return ", ".join(wrong) or "none"


def main() -> None:
    """Measure and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=61)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--repeats", type=int, default=10)
    parser.add_argument("--robot", type=int, default=1, help="seed of the one robot")
    args = parser.parse_args()
    held = measure(different_robots(args.first + args.count - 1)[args.first - 1 :])
    again = repeats(measure(one_robot(args.robot, args.repeats)))
    figures = {"robots": len(held), "quantities": coverage(held), "repeats": again}
    write_trust("coverage", section(args.first, held, again), figures)
    for name, found in coverage(held).items():
        print(f"{name:12} inside {found['inside']:.3f}, RMS {found['rms_in_std']:.2f} std")
    print(again)
    print(f"outside {LOWEST:.0%} to {HIGHEST:.0%}: {_outside(held)}")


if __name__ == "__main__":
    main()

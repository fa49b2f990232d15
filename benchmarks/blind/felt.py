"""What the cells of a simulated session truly felt, before any law or noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from blind.motions import PlannedMotion
from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.planning.motion_sets import TRAIN
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import columns_in_left
from shoecal_core.simulation.samples import SimulatedSamples


@dataclass(frozen=True)
class Felt:
    """T samples of all runs, one behind the other.

    Attributes:
        run: (T,) index of the run, from 0.
        time, since: (T,) since the session and since the run began [s].
        forces: (T, n) on the cells [N].
        speeds: (T, m) of the joints [rad/s].
        shoe: whose cells they are.
        columns: (T, n, 3) wrench in the left sole's frame of a unit force on each cell.
        training: (T,) whether the sample's run is there to calibrate.
    """

    run: IntArray
    time: FloatArray
    since: FloatArray
    forces: FloatArray
    speeds: FloatArray
    shoe: Shoe
    columns: FloatArray
    training: BoolArray

    @property
    def runs(self) -> list[slice]:
        """Samples of each run."""
        ends = np.searchsorted(self.run, np.arange(self.run[-1] + 2))
        return [slice(int(begin), int(end)) for begin, end in pairwise(ends)]


def felt(
    shoe: Shoe,
    motions: Sequence[PlannedMotion],
    samples: Sequence[SimulatedSamples],
    forces: Sequence[FloatArray],
    starts: Sequence[float],
) -> Felt:
    """Put the runs of a session one behind the other.

    Args:
        shoe: that was worn.
        motions, samples: of each run.
        forces: (T_run, n) of each run [N].
        starts: when each began, in the session's time [s].
    """
    counts = [len(one.time) for one in samples]
    since = [one.time - one.time[0] for one in samples]
    columns = [columns_in_left(shoe, one.run.support) for one in motions]
    return Felt(
        run=np.repeat(np.arange(len(counts)), counts),
        time=np.concatenate([a + b for a, b in zip(starts, since, strict=True)]),
        since=np.concatenate(since),
        forces=np.concatenate(forces),
        speeds=np.concatenate(
            [np.gradient(one.joints.angles, one.time, axis=0) for one in samples]
        ),
        shoe=shoe,
        columns=np.repeat(np.array(columns), counts, axis=0),
        training=np.repeat([one.run.hint == TRAIN for one in motions], counts),
    )

"""What assembling the shoe did to the offsets, by the reading of the bare shoe.

Screwing a cell in shifts its zero. Without a weight the foot's wrench must be that of the shoe
alone: the top plate, which the cells feel, and the parts below, which `foot_wrenches` adds. The
shift d is the smallest one that makes it so: d = A+ (w - A f), with the cells' columns A and
outputs f. What it leaves out (a pattern that sums to no wrench) changes neither force nor CoP.
"""

from __future__ import annotations

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.manual.measurements import LoadReading, Measurements
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.shoe.shoe import FEET, Shoe
from shoecal_core.shoe.wrench import ChannelParameters, at_cop, foot_wrenches, weight_below


def shoe_wrench(shoe: Shoe, foot: int) -> FloatArray:
    """(3,) floor wrench of the bare shoe in its sole frame [N, N m]."""
    plates = shoe.plates[foot]
    above = at_cop(np.array(plates.mass_above * GRAVITY), plates.com_above[:2])
    wrench: FloatArray = above + weight_below(shoe)[foot]
    return wrench


def assembled(
    loads: Measurements, parameters: ChannelParameters, covariance: FloatArray | None
) -> tuple[ChannelParameters, FloatArray | None, FloatArray]:
    """Parameters of the assembled shoe.

    Args:
        loads: holds the bare reading of each shoe.
        parameters: (n,) of the single cells.
        covariance: (2n, 2n) of their [gain, offset], None where unknown.

    Returns:
        Parameters, covariance, and the shift (n,) of each offset [N].

    Raises:
        ShoecalError: when a bare shoe was not read.
    """
    shoe = loads.shoe
    count = len(shoe.names)
    shift = np.zeros(count)
    keep = np.eye(2 * count)
    noise = np.zeros(count)
    for foot in shoe.feet:
        bare = _bare(loads, foot)
        channels = shoe.of_foot(foot)
        readings = np.zeros(count)
        readings[channels] = bare.mean
        columns = _rows(shoe, foot)
        inverse = np.linalg.pinv(columns)
        found = foot_wrenches(shoe, parameters.outputs(readings))[foot]
        missing = shoe_wrench(shoe, foot) - found
        shift[channels] = inverse @ missing[: len(columns)]
        seen = inverse @ columns
        offsets = count + channels
        keep[np.ix_(offsets, offsets)] -= seen
        keep[np.ix_(offsets, channels)] = -seen * bare.mean
        noise[channels] = bare.noise
    if covariance is not None:
        covariance = keep @ covariance @ keep.T + _of_noise(shoe, parameters.gain * noise)
    shifted = ChannelParameters(parameters.gain, parameters.offset + shift)
    known = covariance is not None and bool(np.isfinite(covariance).all())
    return shifted, covariance if known else None, shift


def _rows(shoe: Shoe, foot: int) -> FloatArray:
    """(3, k) force and moments by output of a foot's k channels; (1, k) where they give no CoP."""
    columns = shoe.columns[shoe.of_foot(foot)].T
    return columns if shoe.gives_cop[foot] else columns[:1]


def _bare(loads: Measurements, foot: int) -> LoadReading:
    for entry in loads.of_foot(foot):
        if not entry.load.place:
            return entry
    raise loads.error(
        f"the reading of the bare {FEET[foot]} shoe (0 kg) is missing; it shows what assembling "
        "has done to the offsets"
    )


def _of_noise(shoe: Shoe, noise: FloatArray) -> FloatArray:
    """(2n, 2n) what the noise (n,) of the bare readings [N] adds to the offsets' covariance."""
    count = len(noise)
    added = np.zeros((2 * count, 2 * count))
    for foot in shoe.feet:
        channels = shoe.of_foot(foot)
        columns = _rows(shoe, foot)
        seen = np.linalg.pinv(columns) @ columns
        offsets = count + channels
        added[np.ix_(offsets, offsets)] = seen @ np.diag(noise[channels] ** 2) @ seen.T
    return added

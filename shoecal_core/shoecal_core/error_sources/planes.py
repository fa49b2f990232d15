"""Planes of cells below a stiff plate: three of four determine the fourth."""

from __future__ import annotations

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.settings import SignalSettings
from shoecal_core.samples.samples import Samples
from shoecal_core.shoe.shoe import FEET
from shoecal_core.shoe.wrench import ChannelParameters


def cell_planes(
    samples: Samples, parameters: ChannelParameters, settings: SignalSettings
) -> FloatArray:
    """(2, n) direction in which the outputs of a foot's four cells hardly vary.

    Found by principal components over the samples in which the foot stands; used only where
    the rest is small, as it is for cells below a stiff plate.
    """
    shoe = samples.shoe
    planes = np.zeros((len(FEET), len(shoe.channels)))
    outputs = parameters.outputs(samples.readings)
    for foot in range(len(FEET)):
        own = [i for i in shoe.of_foot(foot) if shoe.columns[i, 0] == 1.0 and not shoe.torque[i]]
        part = outputs[samples.loaded[:, foot]][:, own]
        if len(own) != 4 or len(part) < 10:
            continue
        _, size, directions = np.linalg.svd(part - part.mean(axis=0), full_matrices=False)
        if size[3] <= settings.parity_residual * size[2]:
            planes[foot, own] = directions[3]
    return planes

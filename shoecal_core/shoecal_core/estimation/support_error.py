"""How far the joints are off in saying where the right foot stands."""

from __future__ import annotations

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.body import driven_together
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.joint_fit import JointFit

PLANAR = (0, 1, 5)
"""Of the six numbers of the right sole's pose in the left's: dx, dy, dtheta."""


def support_covariance(joint: JointFit | None, tolerances: Tolerances) -> FloatArray:
    """(3, 3) of dx, dy, dtheta in any double support [m, m, rad].

    What each run has by itself, and what is still believed of the joints' zeros.
    """
    stds = np.array([tolerances.support_m, tolerances.support_m, tolerances.support_rad])
    own: FloatArray = np.diag(stds**2)
    if joint is None:
        return own
    signal_model = joint.signal_model
    zeros = [
        (index, one.deviation.location[0])
        for index, one in enumerate(joint.deviations, start=len(joint.vector))
        if one.deviation.effect == "joint_offset"
    ]
    if not zeros or not signal_model.samples.both.any():
        return own
    robot = signal_model.samples.robot
    mean = signal_model.jacobians.closure[signal_model.samples.both][:, PLANAR].mean(axis=0)
    slopes = np.zeros((3, len(zeros)))
    for column, (_, name) in enumerate(zeros):
        for moved, ratio in driven_together(robot, robot.joint(name)):
            slopes[:, column] += ratio * mean[:, moved]
    indices = np.array([index for index, _ in zeros])
    covariance: FloatArray = own + slopes @ joint.covariance[np.ix_(indices, indices)] @ slopes.T
    return covariance

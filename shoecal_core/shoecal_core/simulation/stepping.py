"""Steps of the physics engine, which end in an error where the simulation diverges."""

from __future__ import annotations

import logging

import mujoco

from shoecal_core.simulation.faults import SimulationDivergedError

_DIVERGED = (
    mujoco.mjtWarning.mjWARN_BADQPOS,
    mujoco.mjtWarning.mjWARN_BADQVEL,
    mujoco.mjtWarning.mjWARN_BADQACC,
)

# Without a handler the engine writes its warnings to a file in the current folder.
mujoco.set_mju_user_warning(logging.getLogger(__name__).warning)


def advance(model: mujoco.MjModel, data: mujoco.MjData, count: int = 1) -> None:
    """Advance the physics by some steps.

    Raises:
        SimulationDivergedError: when a state is not finite; the engine alone would start again from
            the initial state, as if nothing had happened.
    """
    begin = data.time
    mujoco.mj_step(model, data, nstep=count)
    if any(data.warning[kind].number for kind in _DIVERGED):
        mujoco.mj_resetData(model, data)
        raise SimulationDivergedError(begin)

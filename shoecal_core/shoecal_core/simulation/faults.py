"""What can go wrong with a simulated robot."""

from __future__ import annotations

from shoecal_core.errors import ShoecalError


class RobotFellError(ShoecalError):
    """The robot fell.

    Attributes:
        time: simulated time [s].
    """

    def __init__(self, robot: str, time: float, tilt: float, height: float) -> None:
        self.time = time
        super().__init__(
            f"simulated robot '{robot}' fell at {time:.2f} s (soles tilted by {tilt:.2f} rad, "
            f"CoM at {height:.0%} of its standing height); plan a slower motion or a wider stance"
        )


class SupportNotReachedError(ShoecalError):
    """The robot could not be brought to stand still in a double support."""


class SimulationDivergedError(ShoecalError):
    """The physics engine met a state that is not finite."""

    def __init__(self, time: float) -> None:
        super().__init__(
            f"the simulation diverged after {time:.2f} s; lower step_s in the reality file, and "
            "check the masses and inertias of the URDF"
        )

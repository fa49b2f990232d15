"""Service `shoe/rezero`: offsets corrected while the robot stands still."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.callback_groups import ReentrantCallbackGroup
from shoecal_msgs.srv import Rezero

from shoecal_core.errors import FileError, ShoecalError
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.estimation.uncertainty.expected import Spread, over_polygons
from shoecal_core.estimation.uncertainty.stated_error import StatedError
from shoecal_core.workflows.rezero import Rezeroed, rezero
from shoecal_ros.calibrator.calibration_server import CalibrationServer
from shoecal_ros.calibrator.calibrator_base import CalibratorBase
from shoecal_ros.common.refusal import RefusedError, faults_refused
from shoecal_ros.common.waiting import aside, until
from shoecal_ros.inputs.joining import Joined
from shoecal_ros.inputs.joints import JointBatch
from shoecal_ros.inputs.standstill import UNREST_N, Standstill

Codes = Rezero.Response
STILL_PATIENCE = 15.0
"""How many times the time of standing still is waited for it, by the wall clock."""
CURE = "lift each foot once and call shoe/rezero again, or calibrate again"


class RezeroServer:
    """One correction at a time, applied by the server that holds the calibration in force."""

    def __init__(self, node: CalibratorBase, calibrations: CalibrationServer) -> None:
        self._node, self._calibrations = node, calibrations
        self._standstill: Standstill | None = None
        # It takes a while, in which everything else must go on.
        node.create_service(
            Rezero, "shoe/rezero", self._rezero, callback_group=ReentrantCallbackGroup()
        )

    @property
    def busy(self) -> bool:
        """Whether a correction is under way."""
        return self._standstill is not None

    def take_readings(self, joined: Sequence[Joined]) -> None:
        """Readings for a correction under way."""
        if self._standstill is not None:
            self._standstill.take_readings(joined)

    def take_joints(self, batch: JointBatch) -> None:
        """Joint angles likewise."""
        if self._standstill is not None:
            self._standstill.take_joints(batch)

    async def _rezero(self, request: Rezero.Request, response: Rezero.Response) -> Rezero.Response:
        del request
        try:
            with faults_refused(self._node.log, Codes.FAILED, ShoecalError):
                await self._do(response)
        except ShoecalError as error:
            response.error_code, response.message = _code(error), str(error)
        return response

    async def _do(self, response: Rezero.Response) -> None:
        """Observe, correct, apply, answer; ShoecalError where that cannot be done."""
        node, calibrations = self._node, self._calibrations
        current = calibrations.store.current
        if current is None:
            raise RefusedError(
                Codes.UNCALIBRATED, "uncalibrated: there are no offsets; calibrate first"
            )
        if node.job_under_way or self.busy:
            reported = node.job_under_way or "a correction"
            raise RefusedError(Codes.BUSY, f"{reported} is under way; wait for it")
        if problem := node.input_problem():
            raise RefusedError(Codes.STALE_INPUT, problem.message)
        found = self._correct(current, await self._observe())
        if calibrations.changing or calibrations.store.current is not current:
            raise RefusedError(
                Codes.SUPERSEDED, "another calibration came in force meanwhile; call again"
            )
        if found.directions:
            await calibrations.apply_corrected(found.calibration)
        self._answer(found, await self._expected(found.calibration), response)

    async def _observe(self) -> Standstill:
        """A standstill; begun again whenever the robot moves."""
        node, duration = self._node, self._node.node_settings.rezero_time
        self._standstill = standstill = Standstill(duration)
        node.stillness.restart()

        def observed() -> bool:
            if not node.stillness.still:
                standstill.restart()
            return standstill.done or node.input_problem() is not None

        try:
            came = await until(observed, STILL_PATIENCE * duration)
        finally:
            self._standstill = None
        if problem := node.input_problem():
            raise RefusedError(Codes.STALE_INPUT, problem.message)
        if not came:
            raise RefusedError(
                Codes.NOT_STILL,
                f"the robot did not stand still for {duration:g} s; stop what moves it",
            )
        if standstill.bad:
            bad = ", ".join(node.shoe.names[index] for index in sorted(standstill.bad))
            raise RefusedError(Codes.BAD_CELLS, f"no good readings of {bad}; correct that first")
        return standstill

    def _correct(self, current: Calibration, standstill: Standstill) -> Rezeroed:
        node = self._node
        unrest = standstill.unrest(current.sensing(node.shoe))
        if unrest > UNREST_N:
            raise RefusedError(
                Codes.NOT_STILL,
                f"the force on the floor varies by {unrest:.1f} N though the joints stand still; "
                "see that nothing touches the robot",
            )
        return rezero(
            current,
            node.shoe,
            standstill.readings,
            node.kinematics.states(standstill.angles[None]),
            node.tolerance,
            largest=node.node_settings.rezero_limit,
            made_ns=node.now_ns,
            temperature=node.voltages.temperature,
        )

    async def _expected(self, calibration: Calibration) -> tuple[Spread, Spread, Spread] | None:
        """Error that is left of both feet, left and right; None where it is not known."""
        node = self._node
        stated = StatedError.of_calibration(calibration, node.robot, node.shoe, node.tolerances)
        if stated is None:
            return None
        return await aside(lambda: over_polygons(stated, node.robot, node.shoe))

    def _answer(
        self,
        found: Rezeroed,
        expected: tuple[Spread, Spread, Spread] | None,
        response: Rezero.Response,
    ) -> None:
        fresh, (before, after) = found.calibration, (found.before, found.after)
        response.success = True
        response.channel, response.change = list(fresh.channels), found.change.tolist()
        response.directions, response.channels = found.directions, len(found.change)
        if before is not None and after is not None:
            response.grf_before, response.grf_after = before.grf_error, after.grf_error
            response.cop_before, response.cop_after = before.cop_error, after.cop_error
        response.grf_left = response.cop_left = float("nan")
        left = "how much is left is unknown: the calibration has no covariance"
        if expected is not None:
            both, *feet = expected
            response.grf_left, response.cop_left = both.grf_rms, both.cop_rms
            left = (
                f"expected error left: GRF {both.grf_rms:.2f} N, CoP "
                f"{1e3 * both.cop_rms:.1f} mm on both feet and "
                f"{1e3 * max(foot.cop_rms for foot in feet):.1f} mm on one"
            )
        response.message = f"'{fresh.id}' in force: {found.summary}; {left}: {CURE}"


def _code(error: ShoecalError) -> int:
    """Of `Rezero.Response`."""
    if isinstance(error, RefusedError):
        return error.code
    found: int = Codes.NOT_SAVED if isinstance(error, FileError) else Codes.TOO_FAR
    return found

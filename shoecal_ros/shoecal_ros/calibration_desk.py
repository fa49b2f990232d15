"""The calibration in force: its services, its latched message and its mirror in parameters."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.parameter import Parameter
from shoecal_msgs.action import Calibrate
from shoecal_msgs.msg import ShoeCalibration
from shoecal_msgs.srv import GetCalibration, Rezero, SetCalibration
from std_srvs.srv import Trigger

from shoecal_core.calibration.calibration import Calibration
from shoecal_core.calibration.rezero import RezeroError, rezero
from shoecal_core.errors import ShoecalError
from shoecal_ros import qos
from shoecal_ros.calibration_store import CalibrationStore, NotApplicableError
from shoecal_ros.conversions import calibration_from_ros, calibration_to_ros, time_to_ros
from shoecal_ros.joining import Joined
from shoecal_ros.joints import JointBatch
from shoecal_ros.refusal import RefusedError
from shoecal_ros.rezeroing import Standstill
from shoecal_ros.runtime import until

if TYPE_CHECKING:
    from shoecal_ros.nodes.calibrator import Calibrator

MIRROR = "in_force."
"""Prefix of the parameters that mirror the calibration in force."""
STILL_PATIENCE = 15.0
"""How many times the time of standing still is waited for it, by the wall clock."""


class CalibrationDesk:
    """Applies calibrations whole or not at all.

    Attributes:
        store: what is in force, and the files.
        problem: what of the files could not be taken, empty when all is well.
    """

    def __init__(self, node: Calibrator, store: CalibrationStore) -> None:
        self.store = store
        self.problem = store.load()
        self._node = node
        self._standstill: Standstill | None = None
        self._since_ns = 0
        self._mirroring = False
        self._publisher = node.create_publisher(ShoeCalibration, "shoe/calibration", qos.LATCHED)
        node.create_service(GetCalibration, "shoe/get_calibration", self._get)
        node.create_service(SetCalibration, "shoe/set_calibration", self._set)
        node.create_service(Trigger, "shoe/rollback", self._rollback)
        # It takes a while, in which everything else must go on.
        node.create_service(
            Rezero, "shoe/rezero", self._rezero, callback_group=ReentrantCallbackGroup()
        )
        node.add_on_set_parameters_callback(self._guard)
        if store.current is not None:
            self._put_in_force(store.current)

    def apply_found(self, calibration: Calibration, *, warned: bool) -> None:
        """Apply what a self-calibration found.

        Args:
            calibration: found.
            warned: also one with warnings.

        Raises:
            RefusedError: NOT_APPLIED, with the reason.
        """
        try:
            self._apply(calibration, warned=warned)
        except ShoecalError as error:
            raise RefusedError(Calibrate.Result.NOT_APPLIED, f"not applied: {error}") from error

    def take_readings(self, joined: Sequence[Joined]) -> None:
        """Readings for a correction of offsets under way."""
        if self._standstill is not None:
            self._standstill.take_readings(joined)

    def take_joints(self, batch: JointBatch) -> None:
        """Joint angles likewise."""
        if self._standstill is not None:
            self._standstill.take_joints(batch)

    # Applying

    def _apply(
        self, calibration: Calibration, *, force: bool = False, warned: bool = False
    ) -> None:
        """Check, save, put in force; else nothing has changed.

        Raises:
            ShoecalError: with the cure.
        """
        self.store.check(calibration, force=force)
        if calibration.verdict == "WARN" and not (force or warned):
            raise NotApplicableError(
                f"the checks of calibration '{calibration.id}' warn "
                f"({'; '.join(calibration.reasons)}); follow them and calibrate anew, or set it "
                "with force"
            )
        self.store.apply(calibration)
        self.problem = ""
        self._put_in_force(calibration)

    def _put_in_force(self, calibration: Calibration) -> None:
        node = self._node
        node.live.sensing = calibration.sensing(node.shoe)
        self._since_ns = node.now_ns
        self._publisher.publish(calibration_to_ros(calibration))
        self._mirror(calibration)

    def _mirror(self, calibration: Calibration) -> None:
        values: dict[str, str | float | list[str] | list[float]] = {
            "id": calibration.id,
            "source": calibration.source,
            "verdict": calibration.verdict,
            "channels": list(calibration.channels),
            "gains": calibration.parameters.gain.tolist(),
            "offsets": calibration.parameters.offset.tolist(),
            "weight": float(calibration.weight),
            "time_offset": float(calibration.time_offset),
        }
        self._mirroring = True
        try:
            for name, value in values.items():
                if self._node.has_parameter(MIRROR + name):
                    self._node.set_parameters([Parameter(MIRROR + name, value=value)])
                else:
                    descriptor = ParameterDescriptor(
                        description="mirror of the calibration in force; cannot be set"
                    )
                    self._node.declare_parameter(
                        MIRROR + name, value, descriptor, ignore_override=True
                    )
        finally:
            self._mirroring = False

    def _guard(self, parameters: list[Parameter]) -> SetParametersResult:
        mirrored = any(parameter.name.startswith(MIRROR) for parameter in parameters)
        return SetParametersResult(
            successful=self._mirroring or not mirrored,
            reason="a calibration is set whole: use the service shoe/set_calibration",
        )

    # Services

    def _get(
        self, request: GetCalibration.Request, response: GetCalibration.Response
    ) -> GetCalibration.Response:
        del request
        current = self.store.current
        if current is not None:
            response.calibrated = True
            response.calibration = calibration_to_ros(current)
            response.since = time_to_ros(self._since_ns)
        return response

    def _set(
        self, request: SetCalibration.Request, response: SetCalibration.Response
    ) -> SetCalibration.Response:
        try:
            calibration = calibration_from_ros(request.calibration)
            self._apply(calibration, force=request.force)
        except ShoecalError as error:
            response.message = str(error)
        else:
            response.success, response.message = True, f"'{calibration.id}' in force"
        return response

    def _rollback(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        del request
        try:
            calibration = self.store.rollback()
        except ShoecalError as error:
            response.message = str(error)
        else:
            self._put_in_force(calibration)
            response.success, response.message = True, f"'{calibration.id}' in force again"
        return response

    async def _rezero(self, request: Rezero.Request, response: Rezero.Response) -> Rezero.Response:
        del request
        try:
            await self._correct_offsets(response)
        except ShoecalError as error:
            response.message = str(error)
        finally:
            self._standstill = None
        return response

    async def _correct_offsets(self, response: Rezero.Response) -> None:
        node, current = self._node, self.store.current
        if current is None:
            raise NotApplicableError("uncalibrated: there are no offsets; calibrate first")
        if node.calibrating or self._standstill is not None:
            raise NotApplicableError("a calibration or a correction is under way; wait for it")
        if problem := node.input_problem():
            raise NotApplicableError(problem)
        standstill = await self._observe()
        body = node.kinematics.states(standstill.angles[None])
        fresh, change = rezero(
            current, node.shoe, standstill.readings, body,
            largest=node.node_settings.rezero_limit, made_ns=node.now_ns,
        )  # fmt: skip
        # Offsets of a calibration in force are corrected whatever its verdict was.
        self._apply(fresh, force=True)
        response.success = True
        response.message = f"'{fresh.id}' in force"
        response.channel, response.change = list(fresh.channels), change.tolist()

    async def _observe(self) -> Standstill:
        """A standstill; begun again whenever the robot moves."""
        node, duration = self._node, self._node.node_settings.rezero_time
        self._standstill = standstill = Standstill(duration)
        node.stillness.restart()

        def observed() -> bool:
            if self._standstill is not None and not node.stillness.still:
                self._standstill.restart()
            return standstill.done or bool(node.input_problem())

        came = await until(observed, STILL_PATIENCE * duration)
        if problem := node.input_problem():
            raise NotApplicableError(problem)
        if not came:
            raise RezeroError(
                f"the robot did not stand still for {duration:g} s; stop what moves it"
            )
        if standstill.bad:
            bad = ", ".join(node.shoe.names[index] for index in sorted(standstill.bad))
            raise RezeroError(f"no good readings of {bad}; mend that first")
        return standstill

"""The calibration in force: its services, its latched message and its mirror in parameters."""

from __future__ import annotations

import math
from pathlib import Path

from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.parameter import Parameter
from shoecal_msgs.action import Calibrate
from shoecal_msgs.msg import ShoeCalibration
from shoecal_msgs.srv import Apply, GetCalibration, SetCalibration
from std_srvs.srv import Trigger

from shoecal_core.errors import FileError, FileMissingError, ShoecalError
from shoecal_core.estimation.calibration import (
    Calibration,
    WrongShoeError,
    load_calibration,
)
from shoecal_core.estimation.checks.agreement import Judgement
from shoecal_core.screening.verdict import list_reasons
from shoecal_ros.calibrator.active_calibration import UNCALIBRATED, ActiveCalibration
from shoecal_ros.calibrator.agreement_watch import SEE, AgreementWatch
from shoecal_ros.calibrator.calibration_store import CalibrationStore, NotApplicableError
from shoecal_ros.calibrator.calibrator_base import CalibratorBase
from shoecal_ros.calibrator.force_samples import ForceSamples
from shoecal_ros.calibrator.job_work import CALIBRATION
from shoecal_ros.calibrator.run_series import NoSessionNameError, session_folder
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import (
    calibration_from_ros,
    calibration_to_ros,
    origin_from_ros,
    time_to_ros,
)
from shoecal_ros.common.health import Level
from shoecal_ros.common.origin import Origin
from shoecal_ros.common.refusal import RefusedError, faults_refused
from shoecal_ros.common.waiting import aside, until

APPLY = "shoe/apply"
MIRROR = "in_force."
"""Prefix of the parameters that mirror the calibration in force."""


class CalibrationServer:
    """Applies calibrations whole or not at all, one at a time; a disk may take its time.

    Attributes:
        store: what is in force, and the files.
        agreement: of what is in force with weight and model.
        problem: what of the files could not be taken, or why the last self-calibration ended
            without a result; None when all is well, and once a calibration comes in force.
    """

    def __init__(self, node: CalibratorBase) -> None:
        folder = Path(node.node_settings.state_dir).expanduser()
        self.store = store = CalibrationStore(
            folder, node.robot, node.shoe, simulated=node.simulated
        )
        self.problem = store.load(node.now_ns, warned=node.job_settings.apply_warned)
        self.agreement = AgreementWatch(node)
        self._node = node
        self._mirroring = False
        # Of the self-calibrations since this node was started, by their run.
        self._origins: dict[str, Origin] = {}
        # Changes under way and waiting, in their order.
        self._changes: list[object] = []
        self._publisher = node.create_publisher(ShoeCalibration, "shoe/calibration", qos.LATCHED)
        node.serve(GetCalibration, "shoe/get_calibration", self._get)
        node.serve(SetCalibration, "shoe/set_calibration", self._set)
        node.serve(Trigger, "shoe/rollback", self._rollback)
        node.serve(Apply, APPLY, self._apply_run)
        node.mirror = MIRROR
        node.add_on_set_parameters_callback(self._guard)
        if store.current is not None and store.origin is not None:
            self._put_in_force(store.current, store.origin)

    @property
    def in_force(self) -> ActiveCalibration | None:
        """What is in force, None while uncalibrated."""
        store = self.store
        if store.current is None or store.origin is None:
            return None
        temperature = self._node.voltages.temperature
        return ActiveCalibration(store.current, store.origin, store.since_ns, temperature)

    @property
    def changing(self) -> bool:
        """Whether a calibration is just being put in force."""
        return bool(self._changes)

    async def apply_found(self, calibration: Calibration, run_id: str, *, warned: bool) -> None:
        """Apply what a self-calibration found, after whatever else is being put in force.

        Args:
            calibration: found.
            run_id: of the self-calibration.
            warned: also one with warnings.

        Raises:
            RefusedError: NOT_APPLIED, with the reason.
        """
        origin = self._origins[run_id] = self._node.origin
        try:
            await self._apply(calibration, origin, warned=warned)
        except ShoecalError as error:
            reported = f"not applied: {error}"
            if calibration.verdict == "WARN":
                reported += (
                    "; to accept it as it is: ros2 service call "
                    f"{self._node.resolve_service_name(APPLY)} shoecal_msgs/srv/Apply "
                    f"\"{{run_id: '{run_id}'}}\""
                )
            raise RefusedError(Calibrate.Result.NOT_APPLIED, reported) from error

    async def apply_corrected(self, calibration: Calibration) -> None:
        """Apply the one in force with corrected offsets, whatever its checks said.

        Raises:
            ShoecalError: with the cure; also where the standing robot contradicts it.
        """
        self._require_agreement(calibration)
        await self._apply(calibration, self._node.origin, force=True)

    # Applying

    async def _apply(
        self,
        calibration: Calibration,
        origin: Origin,
        *,
        force: bool = False,
        warned: bool = False,
    ) -> None:
        """Check, save, put in force; else nothing has changed.

        Raises:
            ShoecalError: with the cure.
        """
        self.store.check(calibration, origin, force=force, warned=warned, now_ns=self._node.now_ns)
        if not force:
            self._require_agreement(calibration)
        await self._change(calibration, origin)

    async def _change(self, calibration: Calibration, origin: Origin) -> None:
        """Save when it is this one's turn, and put in force.

        Raises:
            ShoecalError: when it cannot be saved.
        """
        mine, now_ns = object(), self._node.now_ns
        self._changes.append(mine)
        try:
            # For a disk, however long: meanwhile the calibration before stays in force.
            await until(lambda: self._changes[0] is mine, math.inf)
            if await aside(lambda: self.store.save(calibration, now_ns, origin)):
                self.store.take(calibration, now_ns, origin)
        finally:
            self._changes.remove(mine)
        self.problem = None
        self._put_in_force(calibration, origin)

    def _require_agreement(self, calibration: Calibration) -> None:
        """A calibration that the standing robot contradicts is not applied."""
        found = self.agreement.judge(calibration)
        if found is not None and found.judgement is Judgement.CONTRADICTS:
            raise NotApplicableError(
                f"calibration '{calibration.id}' contradicts the standing robot: {found.reason}; "
                f"{SEE}; calibrate again, or set it with force"
            )

    def _require_free(self) -> None:
        if self.changing:
            raise RefusedError(
                SetCalibration.Response.BUSY,
                "another calibration is just being put in force; call again",
            )

    def _put_in_force(self, calibration: Calibration, origin: Origin) -> None:
        node = self._node
        node.live.sensing = calibration.sensing(node.shoe)
        node.force_samples = ForceSamples(
            calibration,
            node.robot,
            node.shoe,
            node.tolerances,
            node.frames.soles,
            node.node_settings.sum_frame,
        )
        self.agreement.begin(calibration)
        self._publisher.publish(calibration_to_ros(calibration, origin))
        self._mirror(calibration, origin)

    def _mirror(self, calibration: Calibration, origin: Origin) -> None:
        values: dict[str, str | bool | float | list[str] | list[float]] = {
            "id": calibration.id,
            "source": calibration.source,
            "verdict": calibration.verdict,
            "channels": list(calibration.channels),
            "gains": calibration.parameters.gain.tolist(),
            "offsets": calibration.parameters.offset.tolist(),
            "weight": float(calibration.weight),
            "time_offset": float(calibration.time_offset),
            "simulated_time": origin.simulated,
            "host": origin.host,
            "device": origin.device,
        }
        self._mirroring = True
        try:
            if self._node.has_parameter(f"{MIRROR}id"):
                self._node.set_parameters_atomically(
                    [Parameter(MIRROR + name, value=value) for name, value in values.items()]
                )
            else:
                reported = "mirror of the calibration in force; cannot be set"
                self._node.declare_parameters(
                    "",
                    [
                        (MIRROR + name, value, ParameterDescriptor(description=reported))
                        for name, value in values.items()
                    ],
                    ignore_override=True,
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
        found = self.in_force
        response.temperature = self._node.voltages.temperature
        response.message = UNCALIBRATED
        if found is not None:
            response.calibrated = True
            response.calibration = calibration_to_ros(found.calibration, found.origin)
            response.since = time_to_ros(found.since_ns)
            response.message = found.sentence
        return response

    async def _set(
        self, request: SetCalibration.Request, response: SetCalibration.Response
    ) -> SetCalibration.Response:
        try:
            with faults_refused(self._node.log, SetCalibration.Response.FAILED, ShoecalError):
                self._require_free()
                calibration = calibration_from_ros(request.calibration)
                origin = origin_from_ros(request.calibration)
                await self._apply(calibration, origin, force=request.force)
                doubts = self.agreement.doubts
                response.unconfirmed, response.disagrees = doubts.unconfirmed, doubts.disagrees
        except ShoecalError as error:
            response.error_code, response.message = _code(error), self._refused(error)
        else:
            response.success, response.message = True, self._accepted()
        return response

    async def _apply_run(self, request: Apply.Request, response: Apply.Response) -> Apply.Response:
        node, run_id = self._node, request.run_id
        try:
            with faults_refused(node.log, Apply.Response.FAILED, ShoecalError):
                if reported := node.job_under_way:
                    raise RefusedError(Apply.Response.BUSY, f"{reported} is under way; wait for it")
                self._require_free()
                folder = session_folder(node.job_settings.sessions_dir, run_id)
                calibration = await aside(lambda: load_calibration(folder / CALIBRATION))
                origin = self._origins.get(run_id) or Origin.of(calibration)
                await self._apply(calibration, origin, warned=True)
        except ShoecalError as error:
            response.error_code, response.message = _apply_code(error), self._refused(error)
        else:
            response.success, response.message = True, self._accepted()
        return response

    async def _rollback(
        self, request: Trigger.Request, response: Trigger.Response
    ) -> Trigger.Response:
        del request
        try:
            with faults_refused(self._node.log, SetCalibration.Response.FAILED, ShoecalError):
                self._require_free()
                calibration, origin = self.store.one_before()
                self._require_agreement(calibration)
                await self._change(calibration, origin)
        except ShoecalError as error:
            response.message = self._refused(error)
        else:
            response.success, response.message = True, self._accepted()
        return response

    def _accepted(self) -> str:
        """What is in force now, in words."""
        found = self.in_force
        assert found is not None
        reasons = list_reasons(found.calibration.reasons)
        accepted = f"{found.sentence}: {reasons}" if reasons else found.sentence
        return f"{accepted}; {self.agreement.condition.message}"

    def _refused(self, error: ShoecalError) -> str:
        """Why not, on screen too unless it is only to be called again."""
        if not isinstance(error, RefusedError):
            self._node.log(Level.WARN, f"not in force: {error}")
        return str(error)


def _apply_code(error: ShoecalError) -> int:
    """Of `Apply.Response`, whose other codes are those of `SetCalibration.Response`."""
    if isinstance(error, FileMissingError | NoSessionNameError):
        found: int = Apply.Response.NOT_FOUND
        return found
    code = _code(error)
    return Apply.Response.FAILED if code == SetCalibration.Response.BAD_CALIBRATION else code


def _code(error: ShoecalError) -> int:
    """Of `SetCalibration.Response`."""
    codes = SetCalibration.Response
    found: int = codes.BAD_CALIBRATION
    if isinstance(error, RefusedError):
        found = error.code
    elif isinstance(error, FileError):
        found = codes.NOT_SAVED
    elif isinstance(error, NotApplicableError | WrongShoeError):
        found = codes.NOT_APPLICABLE
    return found

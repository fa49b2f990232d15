"""Holds the calibration in force against weight and modelled CoP by the last second of readings."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.estimation.checks.agreement import Agreement, Compared, Judgement, judge
from shoecal_core.robot.kinematics import BodyStates
from shoecal_ros.calibrator.calibrator_base import CalibratorBase
from shoecal_ros.calibrator.live import Doubts
from shoecal_ros.common.codes import Code
from shoecal_ros.common.health import Condition, Level
from shoecal_ros.inputs.joining import Joined

WINDOW_NS = 10**9
"""Of readings that are judged: long against steps of a gait, short against falling over."""
SAMPLE_NS = 10**7
"""Readings closer together add nothing: errors, not noise, are looked for."""
JUDGE_NS = 250 * 10**6
"""From one judgement to the next: with the window it is known in time what two seconds show."""
GAP_NS = 300 * 10**6
"""Without usable readings for so long it begins again: a spike is left out, and no more."""
SEE = (
    "see that nothing holds or touches the robot, that the floor is level, and that the robot "
    "file's weight is right"
)


class AgreementWatch:
    """Judges by the stamps of the readings, so that it is the node's time that counts."""

    def __init__(self, node: CalibratorBase) -> None:
        """Nothing is in force."""
        self._node = node
        self._calibration: Calibration | None = None
        self._body: BodyStates | None = None
        self._judged_ns = 0
        self._window: deque[tuple[int, FloatArray]] = deque()
        self._grf: Compared | None = None
        self._cop: Compared | None = None

    def begin(self, calibration: Calibration) -> None:
        """Another calibration is in force."""
        self._calibration, self._grf, self._cop = calibration, None, None
        self._note(self.judge(calibration))

    def take(self, joined: Sequence[Joined], body: BodyStates | None) -> None:
        """Take readings in order, and judge where it is time to.

        Args:
            joined: readings.
            body: its last state; None while joint angles are stale.
        """
        self._body = body
        for one in joined:
            self._add(one)
        if not self._window or self._calibration is None:
            return
        last_ns = self._window[-1][0]
        if not 0 <= last_ns - self._judged_ns < JUDGE_NS:
            self._judged_ns = last_ns
            self._note(self.judge(self._calibration))

    def judge(self, calibration: Calibration) -> Agreement | None:
        """Any calibration of these shoes, by what has come; None where that is not enough."""
        node, window = self._node, self._window
        if not window or window[-1][0] - window[0][0] < WINDOW_NS or not node.voltages.fresh:
            return None
        return judge(
            calibration, node.robot, node.shoe, np.stack([readings for _, readings in window]),
            self._body if node.stillness.still else None, node.tolerance,
            false_alarm=node.node_settings.drift_false_alarm,
        )  # fmt: skip

    @property
    def doubts(self) -> Doubts:
        """Whether what is in force was not judged yet, or is off by more than is stated."""
        found = self._found
        return Doubts(
            unconfirmed=self._calibration is not None and found is None,
            disagrees=found is not None and found.judgement > Judgement.AGREES,
        )

    @property
    def usable(self) -> bool:
        """Whether forces may be used: judged, and not contradicted."""
        found = self._found
        return found is not None and found.judgement < Judgement.CONTRADICTS

    @property
    def condition(self) -> Condition:
        """For diagnostics."""
        found = self._found
        if self._calibration is None:
            return Condition(Level.OK, "no calibration to hold against the weight")
        if found is None:
            return Condition(
                Level.WARN,
                "unconfirmed, so no forces are valid: let the robot stand for a second",
                code=Code.UNCONFIRMED,
            )
        if found.judgement is Judgement.AGREES:
            return Condition(Level.OK, f"agrees with the robot: {found.reason}")
        cure = f"{SEE}, then call shoe/rezero, or calibrate again"
        if found.judgement is Judgement.DISAGREES:
            return Condition(
                Level.WARN,
                f"disagrees with the robot: {found.reason}; {cure}",
                code=Code.DISAGREES,
            )
        return Condition(
            Level.ERROR,
            f"contradicted by the robot, so no forces are valid: {found.reason}; {cure}",
            code=Code.CONTRADICTED,
        )

    @property
    def _found(self) -> Agreement | None:
        """What was judged last of each, of GRF at least."""
        return None if self._grf is None else Agreement(self._grf, self._cop)

    def _note(self, found: Agreement | None) -> None:
        # A robot in the air or in motion takes back nothing that it showed standing.
        if found is not None:
            self._grf, self._cop = found.grf, found.cop or self._cop

    def _add(self, one: Joined) -> None:
        """Keep good readings of the last second; after a gap it begins again."""
        if one.status.any():
            return
        window = self._window
        age_ns = one.stamp_ns - window[-1][0] if window else SAMPLE_NS
        if not 0 <= age_ns <= GAP_NS:
            window.clear()
        elif age_ns < SAMPLE_NS:
            return
        window.append((one.stamp_ns, one.readings))
        while len(window) > 1 and one.stamp_ns - window[1][0] >= WINDOW_NS:
            window.popleft()

"""Node `nao_lola_adapter`: trajectories to the positions that nao_lola takes, heat from it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sensor_msgs.msg import Temperature

from shoecal_core.arrays import FloatArray
from shoecal_core.settings import Settings, setting
from shoecal_ros.adapters.foreign import foreign
from shoecal_ros.adapters.lola import NUMBERS, numbered
from shoecal_ros.adapters.streaming_adapter import StreamingAdapter, unheard
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import header_to_ros
from shoecal_ros.common.process import run


@dataclass(frozen=True)
class NaoLolaSettings(Settings):
    """How positions are sent."""

    rate: float = setting(
        83.0, "Hz", "set points a second; LoLA's own cycle is 12 ms", minimum=10.0, maximum=200.0
    )
    heat_rate: float = setting(
        1.0, "Hz", "temperatures of every motor a second", minimum=0.1, maximum=20.0
    )


class NaoLolaAdapter(StreamingAdapter):
    """`joint_states` need no adapter: nao_lola's have the names of the NAO's URDF."""

    def __init__(self) -> None:
        super().__init__("nao_lola_adapter")
        settings = self.settings(NaoLolaSettings)
        self._positions = foreign("nao_lola_command_msgs", "msg", "JointPositions")
        heat = foreign("nao_lola_sensor_msgs", "msg", "JointTemperatures")
        self._effectors = self.create_publisher(
            self._positions, "effectors/joint_positions", qos.COMMAND
        )
        self._temperatures = self.create_publisher(Temperature, "joint_temperatures", qos.LIVE)
        self._every_ns = round(1e9 / settings.heat_rate)
        self._sent_ns = 0
        self.subscribe(heat, "sensors/joint_temperatures", self._relay, qos.EITHER)
        self.send_at(settings.rate)

    @property
    def missing(self) -> str:
        """Why no node takes positions; empty where one does."""
        return unheard(self._effectors, "nao_lola")

    def send(self, names: Sequence[str], angles: FloatArray) -> None:
        """Publish set points (k,) [rad] of the joints that LoLA numbers."""
        indexes, positions = numbered(names, angles.tolist())
        self._effectors.publish(self._positions(indexes=indexes, positions=positions))

    def _relay(self, messages: list[Any]) -> None:
        now_ns = self.now_ns
        # After a clock was set back, too.
        if 0 <= now_ns - self._sent_ns < self._every_ns:
            return
        self._sent_ns = now_ns
        for name, number in NUMBERS.items():
            degc = float(messages[-1].temperatures[number])
            header = header_to_ros(now_ns, name)
            self._temperatures.publish(Temperature(header=header, temperature=degc))


def main() -> None:
    """Run the node."""
    run(NaoLolaAdapter)


if __name__ == "__main__":
    main()

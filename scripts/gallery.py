"""Run the examples, and keep their pictures in docs/images.

    .venv/bin/python scripts/gallery.py [--out FOLDER]

The CoP that read_cop.py reads is of the session of calibrate_session.py, published here.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from shoecal_core import Session, evaluate_session, load_calibration
from shoecal_core.workspace import ros_environment

ROOT = Path(__file__).resolve().parents[1]
IMAGES = ROOT / "docs/images"
EXAMPLES: dict[str, tuple[str, ...]] = {
    "calibrate_session": (),
    "diagnose_session": (),
    "own_effect": (),
    "own_shoe": (),
    "correct_mjcf": (),
    "import_log": ("--session", "session"),
    "compare_calibrations": ("--session", "session"),
    "read_cop": ("--count", "200"),
}
"""Arguments of each, in their order."""
RUN, EVERY, PERIOD_S = 4, 10, 0.02
"""The run whose CoP is published, every so many samples."""
PUBLISHER = "--publish"


def main() -> None:
    """Draw all pictures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, help="keep the results of the examples there")
    parser.add_argument(PUBLISHER, action="store_true", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.publish:
        publish(args.out)
        return
    with tempfile.TemporaryDirectory() as folder:
        draw(args.out or Path(folder))


def draw(out: Path) -> None:
    """Run each example, and keep its picture."""
    out.mkdir(parents=True, exist_ok=True)
    for name, words in EXAMPLES.items():
        print(f"{name}.py", flush=True)
        command = [sys.executable, str(ROOT / "examples" / f"{name}.py"), "--out", ".", *words]
        environment = ros_environment() if name == "read_cop" else dict(os.environ)
        with subprocess.Popen(command, cwd=out, env=environment) as example:
            if name == "read_cop":
                source = [sys.executable, __file__, PUBLISHER, "--out", str(out)]
                subprocess.run(source, env=environment, check=True)
            if example.wait():
                raise SystemExit(f"{name}.py ended with {example.returncode}")
        shutil.copy(out / f"{name}.png", IMAGES / f"example-{name.replace('_', '-')}.png")


def publish(out: Path) -> None:
    """The calibrated CoP of a run on /shoe/cop, from its start to its end."""
    # ROS 2 is found in the environment of the process that this is.
    import rclpy  # noqa: PLC0415
    from geometry_msgs.msg import Point, PointStamped  # noqa: PLC0415
    from std_msgs.msg import Header  # noqa: PLC0415

    from shoecal_ros.common import qos  # noqa: PLC0415

    calibration = load_calibration(out / "calibration.yaml")
    runs = evaluate_session(Session.open(out / "session"), calibration).runs
    (run,) = (one for one in runs if one.run == RUN)
    rclpy.init()
    node = rclpy.create_node("gallery")
    publisher = node.create_publisher(PointStamped, "shoe/cop", qos.LIVE)
    while not publisher.get_subscription_count():
        rclpy.spin_once(node, timeout_sec=PERIOD_S)
    for x, y in run.sources["measured"][0].cop[::EVERY]:
        point = Point(x=float(x), y=float(y))
        publisher.publish(PointStamped(header=Header(frame_id="l_sole"), point=point))
        rclpy.spin_once(node, timeout_sec=PERIOD_S)


if __name__ == "__main__":
    main()

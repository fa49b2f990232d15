"""Humanoids as they are published, taken through the commands that `new robot` prints.

    make published ARGS="FOLDER"

FOLDER holds clones of their repositories, FOLDER/NAME each; those that are missing are left out.
Nothing is edited: the rows say how far each one comes, and in its own words why it stops.
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import dataclass
from pathlib import Path

from pages import ROOT, markdown, write_section
from public_robots import PAGE, CommandError, shoecal


@dataclass(frozen=True)
class Published:
    """One description.

    Attributes:
        title: the robot, and whose.
        repository: on github.com.
        file: in it.
    """

    title: str
    repository: str
    file: str

    @property
    def clone(self) -> str:
        """Folder of its repository."""
        return self.repository.rpartition("/")[2]

    @property
    def kind(self) -> str:
        """Format of the file."""
        return "MJCF" if self.file.endswith(".xml") else "URDF"


DUCK = "mini_bdx/robots"
LITE = "HybridRobotics/Berkeley-Humanoid-Lite-Assets"
GR = "FFTAI/Wiki-GRx-Models"
T1 = "BoosterRobotics/booster_gym"
ROBOTS = (
    Published("T1 (Booster)", T1, "resources/T1/T1_serial.urdf"),
    Published("T1 (Booster)", T1, "resources/T1/T1_serial.xml"),
    Published("T1, legs (Booster)", T1, "resources/T1/T1_locomotion.urdf"),
    Published("T1, legs (Booster)", T1, "resources/T1/T1_locomotion.xml"),
    Published("Berkeley Humanoid Lite", LITE, "data/urdf/berkeley_humanoid_lite.urdf"),
    Published("Berkeley Humanoid Lite", LITE, "data/mjcf/berkeley_humanoid_lite.xml"),
    Published("the same, legs", LITE, "data/urdf/berkeley_humanoid_lite_biped.urdf"),
    Published("the same, legs", LITE, "data/mjcf/berkeley_humanoid_lite_biped.xml"),
    Published("GR-3 (Fourier)", GR, "GRX/GR3/gr3v2_1_1/basic_urdf/gr3v2_1_1.urdf"),
    Published("GR-3 (Fourier)", GR, "GRX/GR3/gr3v2_1_1/mjcf/gr3v2_1_1.xml"),
    Published("GR-2 (Fourier)", GR, "GRX/GR2/gr2v3_8_7/basic_urdf/gr2v3_8_7.urdf"),
    Published("GR-2 (Fourier)", GR, "GRX/GR2/gr2v3_8_7/mjcf/gr2v3_8_7.xml"),
    Published("GR-1 T1 (Fourier)", GR, "GRX/GR1/gr1t1/basic_urdf/gr1t1.urdf"),
    Published(
        "Open Duck Mini v2", "apirrone/Open_Duck_Mini", f"{DUCK}/open_duck_mini_v2/robot.urdf"
    ),
    Published("BDX (Open Duck)", "apirrone/Open_Duck_Mini", f"{DUCK}/bdx/robot.xml"),
    Published("Poppy", "poppy-project/poppy-humanoid", "hardware/URDF/robots/Poppy_Humanoid.URDF"),
    Published(
        "Wolfgang (Hamburg Bit-Bots)",
        "bit-bots/wolfgang_robot",
        "wolfgang_description/urdf/robot.urdf",
    ),
)


def main() -> int:
    """Run all that are there, write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="of the clones")
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "published")
    args = parser.parse_args()
    rows = []
    for number, robot in enumerate(ROBOTS):
        file = args.folder / robot.clone / robot.file
        if not file.is_file():
            print(f"{file} is not there", file=sys.stderr)
            continue
        out = args.out / f"{number:02d}"
        result = out / "result.json"
        if not result.is_file():
            print(f"{robot.title}, {robot.kind} …", flush=True)
            out.mkdir(parents=True, exist_ok=True)
            found = taken_through(file, out)
            found["where it stops"] = found["where it stops"].replace(f"{args.folder}/", "")
            result.write_text(json.dumps(found, indent=1) + "\n")
        of = f"[{robot.title}](https://github.com/{robot.repository})"
        found = json.loads(result.read_text())
        rows.append({"robot": of, "format": robot.kind, **found})
    write_section("published", markdown(rows), PAGE)
    print(PAGE)
    return 0


def taken_through(file: Path, out: Path) -> dict[str, str]:
    """Draft, plan, simulate and calibrate; how far it came."""
    robot, shoe = out / "robot.yaml", out / "robot_shoe.yaml"
    session = out / "session"
    steps = (
        ("drafted", ("new", "robot", file, "-o", robot, "--force")),
        ("planned", ("plan", robot, "--shoe", shoe, "--supports", 1, "--out", out / "plan")),
        (
            "simulated",
            ("simulate", robot, shoe, "--reality", out / "robot_reality.yaml", "--out", session),
        ),
        ("calibrated", ("calibrate", session, "--out", out / "calibration.yaml")),
    )
    found = dict.fromkeys((name for name, _ in steps), "")
    found["CoP expected (mm)"] = found["where it stops"] = ""
    for name, words in steps:
        try:
            said = shoecal(out / f"{name}.json", *words)
        except CommandError as error:
            found[name], found["where it stops"] = "no", str(error)
            return found
        found[name] = "yes"
    expected = said["assessment"]["expected_error"]["both"]["cop_std_mm"]
    found["CoP expected (mm)"] = f"{expected:.1f}"
    return found


if __name__ == "__main__":
    sys.exit(main())

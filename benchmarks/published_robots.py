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
BOOSTER = "BoosterRobotics/booster_assets"
UNITREE = "unitreerobotics/unitree_ros"
DATA = "Gepetto/example-robot-data"
ERGO = "icub-tech-iit/ergocub-software"
PLAYGROUND = "google-deepmind/mujoco_playground"
LIVELY = "HighTorque-Robotics/livelybot_pi_rl_baseline"
TIDE = "HighTorque-Robotics/robot_urdf"
GYM = "mujoco_playground/_src/locomotion"
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
    Published(
        "REEM-C (PAL Robotics)",
        "pal-robotics/reemc_robot",
        "reemc_description/robots/reemc_full_ft_hey5.urdf.xacro",
    ),
    Published("G1, 23 joints (Unitree)", UNITREE, "robots/g1_description/g1_23dof_rev_1_0.urdf"),
    Published("G1, 29 joints (Unitree)", UNITREE, "robots/g1_description/g1_29dof_rev_1_0.xml"),
    Published("H1-2 (Unitree)", UNITREE, "robots/h1_2_description/h1_2.urdf"),
    Published("H1 (Unitree)", UNITREE, "robots/h1_description/urdf/h1.urdf"),
    Published("H1 (Unitree)", UNITREE, "robots/h1_description/mjcf/h1.xml"),
    Published("K1 (Booster)", BOOSTER, "robots/K1/K1_22dof.urdf"),
    Published("K1 (Booster)", BOOSTER, "robots/K1/K1_22dof.xml"),
    Published("T1, 29 joints (Booster)", BOOSTER, "robots/T1/T1_29dof.urdf"),
    Published("TALOS (PAL Robotics)", DATA, "robots/talos_data/robots/talos_full_v2.urdf"),
    Published("R1 (Unitree)", UNITREE, "robots/r1_description/R1.urdf"),
    Published("H2 (Unitree)", UNITREE, "robots/h2_description/H2.urdf"),
    Published("iCub 2.7 (IIT)", "robotology/icub-models", "iCub/robots/iCubGazeboV2_7/model.urdf"),
    Published("ergoCub (IIT)", ERGO, "urdf/ergoCub/robots/ergoCubSN001/model.urdf"),
    Published(
        "Berkeley Humanoid", "HybridRobotics/berkeley_humanoid_description", "urdf/robot.urdf"
    ),
    Published(
        "Atlas (Boston Dynamics)", "RobotLocomotion/models", "atlas/atlas_minimal_contact.urdf"
    ),
    Published("Romeo (Aldebaran)", DATA, "robots/romeo_description/urdf/romeo_small.urdf"),
    Published(
        "NAO (Aldebaran)",
        "ros-naoqi/nao_robot",
        "nao_description/urdf/naoV50_generated_urdf/nao.urdf",
    ),
    Published("OP3 (ROBOTIS)", PLAYGROUND, f"{GYM}/op3/xmls/op3_mjx_feetonly.xml"),
    Published("Apollo (Apptronik)", PLAYGROUND, f"{GYM}/apollo/xmls/apollo_mjx_feetonly.xml"),
    Published(
        "Berkeley Humanoid",
        PLAYGROUND,
        f"{GYM}/berkeley_humanoid/xmls/berkeley_humanoid_mjx_feetonly.xml",
    ),
    Published("T1 (Booster)", PLAYGROUND, f"{GYM}/t1/xmls/t1_mjx_feetonly.xml"),
    Published("G1 (Unitree)", PLAYGROUND, f"{GYM}/g1/xmls/g1_mjx_feetonly.xml"),
    Published("G1, 23 joints (Unitree)", UNITREE, "robots/g1_description/g1_23dof_rev_1_0.xml"),
    Published("H1-2 (Unitree)", UNITREE, "robots/h1_2_description/h1_2.xml"),
    Published("Pi Plus (HighTorque)", TIDE, "pi_plus_24dof/urdf/pi_plus_24dof.urdf"),
    Published("Pi Plus (HighTorque)", TIDE, "pi_plus_24dof/xml/pi_plus_20dof.xml"),
    Published("Pi (HighTorque)", TIDE, "pi_12dof/mjcf/pi_12dof.xml"),
    Published("Pai (HighTorque)", LIVELY, "resources/robots/pai_12dof/urdf/pai_12dof.urdf"),
    Published("Pai (HighTorque)", LIVELY, "resources/robots/pai_12dof/mjcf/pai_12dof.xml"),
    Published("T1, 23 joints (Booster)", BOOSTER, "robots/T1/T1_23dof.xml"),
    Published("Hi (HighTorque)", TIDE, "hi_25dof/mjcf/hi_25dof.xml"),
    Published(
        "ToddlerBot, active",
        "hshi74/toddlerbot",
        "toddlerbot/descriptions/toddlerbot_active/toddlerbot_active.xml",
    ),
    Published(
        "ToddlerBot", "hshi74/toddlerbot", "toddlerbot/descriptions/toddlerbot/toddlerbot.xml"
    ),
    Published("Sigmaban (Rhoban)", "Rhoban/sigmaban_urdf", "robot.urdf"),
    Published("JVRC-1", "isri-aist/jvrc_mj_description", "xml/jvrc1.xml"),
    Published("Pi (HighTorque)", TIDE, "pi_12dof/urdf/pi_12dof.urdf"),
    Published("Hi (HighTorque)", TIDE, "hi_25dof/urdf/hi_25dof.urdf"),
    Published("T1, 23 joints (Booster)", BOOSTER, "robots/T1/T1_23dof.urdf"),
    Published(
        "ToddlerBot, active",
        "hshi74/toddlerbot",
        "toddlerbot/descriptions/toddlerbot_active/toddlerbot_active.urdf",
    ),
    Published("JVRC-1", "stephane-caron/jvrc_description", "urdf/jvrc1.urdf"),
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
            found["where it stops"] = _relative(found["where it stops"], args.folder, out)
            result.write_text(json.dumps(found, indent=1) + "\n")
        of = f"[{robot.title}](https://github.com/{robot.repository})"
        found = json.loads(result.read_text())
        rows.append({"robot": of, "format": robot.kind, **found})
    write_section("published", markdown(rows), PAGE)
    print(PAGE)
    return 0


def _relative(said: str, *folders: Path) -> str:
    """What was said, files as seen from these folders."""
    for folder in folders:
        said = said.replace(f"{folder}/", "")
    return said


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

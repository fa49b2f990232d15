"""Draft a robot from its MJCF, simulate it, and correct its files by what the recording shows.

.venv/bin/python examples/correct_mjcf.py --out out/examples [--mjcf FILE]
"""

import argparse
from pathlib import Path

import mujoco
import yaml
from matplotlib.figure import Figure

import shoecal_core as sc
from shoecal_core.cli import main as shoecal
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.files import atomic_write
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.workflows.model_correction import correct_robot
from shoecal_core.workspace import config_dir


def wren(file: Path) -> Path:
    spec = mujoco.MjSpec.from_file(str(config_dir() / "robots/wren.urdf"))
    spec.compiler.fusestatic = False  # or the base is a part of the world
    spec.worldbody.first_body().add_freejoint()
    spec.compile()
    file.write_text(spec.to_xml())
    return file


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--mjcf", type=Path, help="of a humanoid (default: Wren, a small one)")
    parser.add_argument("--out", type=Path, default=Path("out/examples"), help="folder of results")
    (folder := (args := parser.parse_args()).out / "mjcf").mkdir(parents=True, exist_ok=True)
    robot, shoe, reality = (str(folder / f"my{end}.yaml") for end in ("", "_shoe", "_reality"))
    mjcf = args.mjcf or wren(folder / "wren.xml")
    new = ["new", "robot", str(mjcf), "--out", robot]
    simulate = ["simulate", robot, shoe, "--reality", reality, "--out", str(folder / "session")]
    if shoecal(new) or shoecal([*simulate, "--supports", "4"]):
        raise SystemExit(1)  # why has been printed
    session = sc.Session.open(folder / "session")
    found = correct_robot(session, (1, 2, 3), (4,), CalibrationSettings(), Tolerances(), mjcf)
    before, after = (1e3 * one.cop.mean for one in (found.before, found.after))
    print(f"CoP against the model: {before:.2f} mm, against the corrected one: {after:.2f} mm")
    for name, text in found.corrected.files.items() if found.better else ():
        atomic_write(folder / name, text)  # robot.xml, its meshes' paths absolute, and others
    coms = [one for one in found.corrected.found if one.component == "x"]
    links = [one.location[0] for one in coms]
    true = yaml.safe_load((folder / "session/truth/reality.yaml").read_text())["com_error_m"]
    axes = (figure := Figure(layout="constrained")).add_subplot(title="CoM of links, forward (mm)")
    axes.plot([1e3 * true[link][0] for link in links], links, "C0x", label="true")
    values, half = [1e3 * one.value for one in coms], [1.96e3 * one.std for one in coms]
    axes.errorbar(values, links, xerr=half, fmt="C1o", label="found, with 95 %", zorder=0)
    figure.legend(loc="outside lower center", ncols=2)
    figure.savefig(args.out / "correct_mjcf.png")


if __name__ == "__main__":
    main()

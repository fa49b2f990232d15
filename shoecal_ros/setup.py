"""Package of the ROS 2 nodes."""

from pathlib import Path
from xml.etree import ElementTree as ET

from setuptools import find_packages, setup

NAME = "shoecal_ros"
HERE = Path(__file__).resolve().parent
VERSION = ET.parse(HERE / "package.xml").findtext("version")
LAYOUTS = ("rviz", "foxglove", "plotjuggler")
NODES = ("shoe_driver", "model", "planner", "calibrator", "simulator")
ADAPTERS = ("nao_lola_adapter", "naoqi_adapter", "controller_adapter")

setup(
    name=NAME,
    version=VERSION,
    description="Robots calibrate the force sensors in their own feet: the ROS 2 nodes.",
    author="The shoecal authors",
    license="Apache-2.0",
    license_files=["LICENSE"],
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (
            f"share/{NAME}/launch",
            [str(file) for file in sorted(Path("launch").glob("*.launch.py"))],
        ),
        *(
            (f"share/{NAME}/{viewer}", [str(file) for file in sorted(Path(viewer).iterdir())])
            for viewer in LAYOUTS
        ),
    ],
    python_requires=">=3.11",
    install_requires=["pyserial>=3.5"],  # and shoecal_core, from the same workspace
    # colcon test takes pytest by this
    extras_require={"test": ["hypothesis", "pytest", "pytest-timeout"]},
    entry_points={
        "console_scripts": [
            *(f"{node} = {NAME}.nodes.{node}:main" for node in (*NODES, *ADAPTERS)),
            f"demo = {NAME}.demo:main",
            f"security_policy = {NAME}.security_policy:main",
            f"example_controller = {NAME}.examples.controller:main",
        ]
    },
    zip_safe=True,
)

"""Package of the ROS 2 nodes."""

from pathlib import Path

from setuptools import find_packages, setup

NAME = "shoecal_ros"
NODES = ("shoe_driver", "model", "planner", "calibrator", "simulator")

setup(
    name=NAME,
    version="0.1.0",
    description="Robots calibrate the force sensors in their own feet: the ROS 2 nodes.",
    author="The shoecal authors",
    license="Apache-2.0",
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (
            f"share/{NAME}/launch",
            [str(file) for file in sorted(Path("launch").glob("*.launch.py"))],
        ),
    ],
    python_requires=">=3.11",
    install_requires=["pyserial>=3.5"],  # and shoecal_core, from the same workspace
    entry_points={
        "console_scripts": [
            *(f"{node} = {NAME}.nodes.{node}:main" for node in NODES),
            f"demo = {NAME}.demo:main",
        ]
    },
    zip_safe=True,
)

"""Package of the method: no ROS, no serial port, no wall clock."""

from pathlib import Path
from xml.etree import ElementTree as ET

from setuptools import find_packages, setup

NAME = "shoecal_core"
HERE = Path(__file__).resolve().parent
VERSION = ET.parse(HERE / "package.xml").findtext("version")


def config_files() -> list[tuple[str, list[str]]]:
    """Every file of the checkout's config/ (linked from here), by its folder under share/."""
    folders: dict[str, list[str]] = {}
    for file in sorted(path for path in (HERE / "config").rglob("*") if path.is_file()):
        relative = file.relative_to(HERE)
        folders.setdefault(f"share/{NAME}/{relative.parent}", []).append(str(relative))
    return list(folders.items())


setup(
    name=NAME,
    version=VERSION,
    description="Robots calibrate the force sensors in their own feet: the method, without ROS.",
    long_description=(HERE / "README.md").read_text(encoding="utf-8"),
    long_description_content_type="text/markdown",
    author="The shoecal authors",
    license="Apache-2.0",
    license_files=["LICENSE"],
    classifiers=[
        "Programming Language :: Python :: 3 :: Only",
        "Topic :: Scientific/Engineering",
        "Typing :: Typed",
    ],
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: ["py.typed", "report/assets/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        *config_files(),
    ],
    python_requires=">=3.11",
    install_requires=[
        "casadi>=3.6.7",
        "coal>=3.0.3",
        "jinja2>=3.1.2",
        "markupsafe>=2.1.5",
        "matplotlib>=3.6.3",
        "mcap>=1.5.0",
        "mujoco>=3.17.0",
        "numpy>=1.26.4",
        "pin==4.1.0",
        "pyyaml>=6.0.1",
        "rich>=13.7.1",
        "rosbags>=0.11.0",
        "scipy>=1.11.4",
        "shapely>=2.0.3",
        "shtab>=1.6.5",
        "zstandard>=0.22.0",
    ],
    extras_require={
        "test": ["hypothesis", "pytest", "pytest-timeout"],  # colcon test takes pytest by this
    },
    entry_points={"console_scripts": ["shoecal = shoecal_core.cli:main"]},
    zip_safe=True,
)

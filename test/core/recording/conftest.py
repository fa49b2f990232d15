from __future__ import annotations

from pathlib import Path

import pytest

from core.recording import samples
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.shoe_file import load_shoe


@pytest.fixture(scope="session")
def shoe(tmp_path_factory: pytest.TempPathFactory) -> Shoe:
    """Three cells a foot."""
    path = tmp_path_factory.mktemp("shoe") / "shoe.yaml"
    path.write_text(samples.SHOE_YAML)
    return load_shoe(path)


@pytest.fixture(scope="session")
def ankles(tmp_path_factory: pytest.TempPathFactory) -> Shoe:
    """Six-axis sensors: five axes on the left, three on the right."""
    path = tmp_path_factory.mktemp("ankles") / "shoe.yaml"
    path.write_text(samples.ANKLE_YAML)
    return load_shoe(path)


@pytest.fixture
def sources(tmp_path: Path) -> samples.Sources:
    """The files a session is made of."""
    folder = tmp_path / "sources"
    folder.mkdir()
    made = samples.Sources(*(folder / name for name in samples.Sources._fields))
    for path, text in zip(made, (samples.ROBOT_YAML, samples.URDF, samples.SHOE_YAML), strict=True):
        path.write_text(text)
    return made

"""Effects of a user's own file, from beginning to end; and what a calibration hides of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from core.diagnosis.drawn import Urn, part
from shoecal_core.diagnosis.answer import hidden_cop
from shoecal_core.diagnosis.selection import select
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.workspace import Workspace, make_workspace
from shoecal_core.error_sources.effects.known import effects_from
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.errors import FileError, FileMissingError, FileSyntaxError

OWN = '''
"""The torso leans to a side: steadily, or to and fro."""

import numpy as np

from shoecal_core.error_sources.base import Component, Shape


class Pulled:
    """A cable that pulls the body aside."""

    identifier, group = "pulled", "body"
    components = (Component("far", "m", 0.003),)

    def __init__(self, swinging):
        self.swinging = swinging

    def places(self, signal_model):
        yield ("swinging" if self.swinging else "steady",)

    def shapes(self, signal_model, place):
        time = signal_model.samples.time
        course = np.sin(5.0 * time) if self.swinging else np.ones_like(time)
        cop = np.stack((0.0 * course, course), axis=1)
        yield Shape(("far",), signal_model.by_model(0.0, cop)[None])


EFFECTS = (Pulled(False), Pulled(True))
'''
SETTINGS = DiagnosisSettings()


@pytest.fixture(scope="module")
def own(workspace: Workspace, tmp_path_factory: pytest.TempPathFactory) -> Urn:
    """The session, to a diagnosis that knows nothing but a user's effects."""
    path = tmp_path_factory.mktemp("own") / "cable.py"
    path.write_text(OWN)
    effects = effects_from(path)
    return Urn.of(
        make_workspace(
            workspace.signal_model, effects, workspace.train, workspace.test, SETTINGS, Tolerances()
        )
    )


def test_an_effect_of_one_s_own_is_found(own: Urn) -> None:
    drawn = own.draw(np.random.default_rng(1), {"pulled (swinging)": [0.004]})
    found = select(drawn, SETTINGS)
    assert found.chosen is not None
    assert [one.label for one, _ in found.chosen.parts] == ["pulled (swinging)"]
    assert found.chosen.sizes == pytest.approx(0.004, rel=0.1)


def test_offsets_hide_what_is_steady_and_not_what_swings(own: Urn) -> None:
    hidden = {}
    for label in ("pulled (steady)", "pulled (swinging)"):
        drawn = own.draw(np.random.default_rng(2), {label: [0.004]})
        scored = drawn.scorer.score([part(drawn, label)])
        size = abs(float(scored.sizes[0]))
        hidden[label] = hidden_cop(drawn, scored, 0) / max(size, 1e-9)
    assert hidden["pulled (steady)"] > 0.4
    assert hidden["pulled (swinging)"] < 0.1


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x = 1\n", "defines no EFFECTS"),
        ("EFFECTS = ()\n", "defines no EFFECTS"),
        ("EFFECTS = 3\n", "defines no EFFECTS"),
        ("EFFECTS = (1,)\n", "is no effect"),
        (
            "class A:\n    identifier = 'a'\nEFFECTS = (A(),)\n",
            "it lacks group, components, places, shapes",
        ),
        ("import nothing_of_this_name\n", "cannot be run: ModuleNotFoundError"),
        ("def (:\n", "cannot be run: SyntaxError"),
    ],
)
def test_what_is_wrong_with_a_file_of_effects_is_told(
    tmp_path: Path, text: str, message: str
) -> None:
    path = tmp_path / "own.py"
    path.write_text(text)
    with pytest.raises(FileError, match=message) as raised:
        effects_from(path)
    assert str(path) in str(raised.value)


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(FileMissingError, match="cannot be read"):
        effects_from(tmp_path / "none.py")


def test_a_file_of_another_kind(tmp_path: Path) -> None:
    (tmp_path / "own.txt").touch()
    with pytest.raises(FileSyntaxError, match="is no Python file"):
        effects_from(tmp_path / "own.txt")

"""What the how-to gives trainers of policies, against stand-ins with the same keys."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from shoecal_core.robot.randomisation import Parameter, Randomisation

PAGE = Path(__file__).parents[3] / "docs" / "how-to" / "randomise-a-policy.md"
FOUND = Randomisation(
    "wren",
    (
        Parameter("joint_zero", "left_knee", 0.03, 0.001),
        Parameter("mass", "body", 0.2, 0.05),
        Parameter("com_x", "body", 0.004, 0.001),
        Parameter("com_y", "body", 0.0, 0.002),
        Parameter("com_z", "body", -0.003, 0.001),
    ),
)


Snippet = dict[str, Callable[[Path], dict[str, Any]]]


class Config:
    """Keeps what it is given."""

    def __init__(self, *name: str, **values: object) -> None:
        self.name = name
        self.values = values


class EventTermCfg:
    """Of a function that takes the params, as managers of events call it: env, env_ids, params."""

    def __init__(
        self, *, func: Callable[..., object], mode: str, params: dict[str, object]
    ) -> None:
        assert mode in ("startup", "reset", "interval")
        self.params = params
        func(None, None, **params)


def mjlab_body(
    env: object, env_ids: object, ranges: object, asset_cfg: object, distribution: str,
    operation: str,
) -> None:  # fmt: skip
    assert distribution in ("uniform", "log_uniform", "gaussian")
    assert operation in ("add", "scale", "abs")


def encoder_bias(
    env: object, env_ids: object, bias_range: tuple[float, float], asset_cfg: object
) -> None:
    assert bias_range[0] < bias_range[1]


def randomize_rigid_body_mass(
    env: object, env_ids: object, asset_cfg: object,
    mass_distribution_params: tuple[float, float], operation: str, distribution: str = "uniform",
    recompute_inertia: bool = True,
) -> None:  # fmt: skip
    assert operation in ("add", "scale", "abs")
    assert distribution in ("uniform", "log_uniform", "gaussian")


def randomize_rigid_body_com(
    env: object, env_ids: object, com_range: dict[str, tuple[float, float]], asset_cfg: object
) -> None:
    assert set(com_range) <= set("xyz")


STAND_INS: dict[str, dict[str, object]] = {
    "mjlab": {},
    "mjlab.envs": {},
    "mjlab.envs.mdp": {},
    "mjlab.envs.mdp.dr": {
        "encoder_bias": encoder_bias, "body_mass": mjlab_body, "body_com_offset": mjlab_body,
    },
    "mjlab.managers": {},
    "mjlab.managers.event_manager": {"EventTermCfg": EventTermCfg},
    "mjlab.managers.scene_entity_config": {"SceneEntityCfg": Config},
    "isaaclab": {},
    "isaaclab.envs": {},
    "isaaclab.envs.mdp": {
        "randomize_rigid_body_mass": randomize_rigid_body_mass,
        "randomize_rigid_body_com": randomize_rigid_body_com,
    },
    "isaaclab.managers": {"EventTermCfg": EventTermCfg, "SceneEntityCfg": Config},
}  # fmt: skip
"""Keys as in mjlab 1.6 and Isaac Lab 2.2."""


@pytest.fixture
def snippet(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Snippet:
    """What a block of the page defines."""
    for name, members in STAND_INS.items():
        module = ModuleType(name)
        vars(module).update(members)
        monkeypatch.setitem(sys.modules, name, module)
        above, _, own = name.rpartition(".")
        if above:
            setattr(sys.modules[above], own, module)
    (code,) = re.findall(
        rf"```python title=out/{request.param}_events.py\n(.*?)```", PAGE.read_text(), re.DOTALL
    )
    defined: Snippet = {}
    exec(compile(code, str(PAGE), "exec"), defined)
    return defined


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "randomisation.yaml"
    path.write_text(FOUND.text())
    return path


@pytest.mark.parametrize("snippet", ["mjlab"], indirect=True)
def test_mjlab_takes_it(snippet: Snippet, file: Path) -> None:
    events = snippet["events_from"](file)
    assert set(events) == {"zero_left_knee", "mass_body", "com_body"}
    half = 3.0**0.5 * 0.001  # of a uniform distribution with this standard deviation
    assert events["zero_left_knee"].params["bias_range"] == pytest.approx(
        (0.03 - half, 0.03 + half)
    )
    assert events["mass_body"].params["ranges"] == (0.2, 0.05)
    assert events["com_body"].params["ranges"] == {
        0: (0.004, 0.001), 1: (0.0, 0.002), 2: (-0.003, 0.001)
    }  # fmt: skip


@pytest.mark.parametrize("snippet", ["isaaclab"], indirect=True)
def test_isaac_lab_takes_it(snippet: Snippet, file: Path) -> None:
    events = snippet["events_from"](file)
    assert set(events) == {"mass_body", "com_body"}
    assert events["mass_body"].params["mass_distribution_params"] == (0.2, 0.05)
    ranges = events["com_body"].params["com_range"]
    assert sum(ranges["z"]) / 2.0 == pytest.approx(-0.003)
    assert snippet["zeros_from"](file) == {"left_knee": (0.03, 0.001)}

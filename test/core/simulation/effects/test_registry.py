from __future__ import annotations

from pathlib import Path

import yaml

from core.simulation.worlds import REALITIES, ROOT, World, load_world
from shoecal_core.simulation.effects.registry import EFFECTS
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.simulation.sampled_robot import draw

DEFAULT = REALITIES / "default.yaml"


def examples() -> list[str]:
    """Items of the list of effects in the default reality's comment."""
    lines = DEFAULT.read_text().splitlines()
    return [line[1:] for line in lines if line.startswith("#   - {effect: ")]


def test_the_default_file_has_an_example_of_every_effect_and_each_can_be_read(
    tmp_path: Path, nao: World
) -> None:
    listed = "\n".join(examples())
    file = tmp_path / "mine.yaml"
    file.write_text(f"format: 1\nname: all of them\neffects:\n{listed}\n")
    named = [item["effect"] for item in yaml.safe_load(listed)]
    assert sorted(named) == sorted(EFFECTS)
    rules = load_reality(DEFAULT, file)
    assert len(draw(rules, nao.robot, nao.shoe, 1).rules.effects) == len(EFFECTS)


def test_every_effect_stands_in_the_table() -> None:
    page = (ROOT / "docs" / "reference" / "effects.md").read_text()
    for name in EFFECTS:
        assert f"\n| `{name}` | " in page, name


def test_a_mixture_of_all_stands(tmp_path: Path) -> None:
    world = load_world("nao")
    file = tmp_path / "mine.yaml"
    file.write_text("format: 1\nname: all of them\neffects:\n" + "\n".join(examples()) + "\n")
    sim = world.standing(load_reality(DEFAULT, file))
    assert sim.upright
    assert sim.truth().grf > 50.0

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import pytest
import yaml

from core.simulation.worlds import DEFAULT, PERFECT, REALITIES, World
from shoecal_core.errors import FileError, VersionError
from shoecal_core.simulation.reality import PlantVariation
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.simulation.sampled_robot import draw


def load(tmp_path: Path, text: str) -> PlantVariation:
    file = tmp_path / "mine.yaml"
    file.write_text(f"format: 1\nname: mine\n{text}")
    return load_reality(REALITIES / "default.yaml", file)


def test_an_override_changes_only_what_it_names(tmp_path: Path) -> None:
    mine = load(tmp_path, "servo: {friction_fraction: 0.07}\nshoes: {clamp_share: {left: 0.3}}\n")
    assert mine.servo.friction_fraction == 0.07
    assert dict(mine.shoes.clamp_share.rows) == {"left": (0.3,)}
    assert mine.servo == dataclasses.replace(DEFAULT.servo, friction_fraction=0.07)
    assert mine.shoes.mass_error_fraction == DEFAULT.shoes.mass_error_fraction
    for name in ("step_s", "body", "joints", "cells", "floor", "rig", "effects"):
        assert getattr(mine, name) == getattr(DEFAULT, name)


def test_the_default_names_every_key_under_a_comment() -> None:
    lines = (REALITIES / "default.yaml").read_text().splitlines()
    for index, line in enumerate(lines):
        if re.match(r"\s*(?!format|name)\w+:", line):
            above = [before.strip()[:1] == "#" for before in lines[max(0, index - 3) : index]]
            assert any(above), f"line {index + 1} is not explained"


def test_every_key_of_the_default_is_needed(tmp_path: Path) -> None:
    content = yaml.safe_load((REALITIES / "default.yaml").read_text())
    for section in [name for name, value in content.items() if isinstance(value, dict)]:
        for key in content[section]:
            less = {**content, section: {k: v for k, v in content[section].items() if k != key}}
            file = tmp_path / "less.yaml"
            file.write_text(yaml.safe_dump(less))
            with pytest.raises(FileError, match=rf"{section}\.{key}: is missing"):
                load_reality(file)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("cells: {stiffness_n_per_mm: 100}", r"cells\.stiffness_n_per_mm: unknown key; did you"),
        ("cell: {}", r"cell: unknown key"),
        ("servo: {friction_fraction: much}", r"servo\.friction_fraction: expected a number"),
        ("servo: {friction_fraction: -0.1}", r"servo\.friction_fraction: must be at least 0"),
        ("servo: {friction_fraction:}", r"servo\.friction_fraction: is missing"),
        ("step_s: 0", r"step_s: must be above 0"),
        ("engine: {integrator: rk4}", r"engine\.integrator: .*discrete, implicit, implicitfast"),
        ("cells: {converter_bits: 2.5}", r"cells\.converter_bits: expected a whole number"),
        ("cells: {position_error_m: {a: [1]}}", r"position_error_m\.a: expected 2 numbers"),
        ("joints: {play_rad: {all: -1}}", r"joints\.play_rad\.all: must be at least 0"),
        ("effects: [{effect: ghosts}]", r"effects\[0\]\.effect: 'ghosts' is not one of: \w+, "),
        ("effects: [{effect: latency, location: [left]}]", r"effects\[0\]\.delay_s: is missing"),
        (
            "effects: [{effect: latency, location: [nose], delay_s: 0.1}]",
            r"effects\[0\]\.location: 'nose' is not one of: left, right, all",
        ),
    ],
)
def test_a_wrong_file_is_one_clear_error(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(FileError, match=message) as caught:
        load(tmp_path, text)
    assert "mine.yaml" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_newer_file_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "new.yaml"
    file.write_text("format: 2\nname: new\n")
    with pytest.raises(VersionError):
        load_reality(REALITIES / "default.yaml", file)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("body: {mass_error_fraction: {Tail: 0.1}}", "no link 'Tail'"),
        ("body: {com_error_m: {Tail: [0, 0, 0]}}", "no link 'Tail'"),
        ("joints: {play_rad: {TailPitch: 0.1}}", "no joint 'TailPitch'"),
        ("joints: {encoder_error_rad: {TailPitch: 0.1}}", "no joint 'TailPitch'"),
        ("cells: {position_error_m: {left/nose: [0, 0]}}", "no channel 'left/nose'"),
        ("shoes: {clamp_share: {middle: 0.1}}", "no foot 'middle'"),
    ],
)
def test_a_name_that_the_robot_lacks_is_one_clear_error(
    tmp_path: Path, nao: World, text: str, message: str
) -> None:
    rules = load(tmp_path, text)
    with pytest.raises(FileError, match=message) as caught:
        draw(rules, nao.robot, nao.shoe, 1)
    assert "mine.yaml" in str(caught.value)


def test_nothing_is_off_in_the_perfect_reality(world: World) -> None:
    drawn = draw(PERFECT, world.robot, world.shoe, 7)
    body, shoes = drawn.body, drawn.shoes
    assert body.mass == pytest.approx(world.robot.mass - world.shoe.mass)
    for errors in (body.com_error, body.encoder_error, body.play, body.compliance):
        assert not errors.any()
    assert (body.mass_factor == 1.0).all()
    assert (shoes.position == world.shoe.positions).all()
    for errors in (shoes.parameters.offset, shoes.noise, shoes.latency, shoes.clamp_share):
        assert not errors.any()

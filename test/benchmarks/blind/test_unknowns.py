"""Effects outside the library: statics by hand."""

from __future__ import annotations

import numpy as np
import pytest

from blind.unknowns import KINDS, Edge, Hand, LoosePlate, shares

CORNERS = np.array([[0.1, 0.05], [0.1, -0.05], [-0.05, 0.05], [-0.05, -0.05]])


def test_a_plate_shares_a_load_as_statics_demand() -> None:
    point = np.array([0.03, 0.02])
    part = shares(CORNERS, point)
    assert part.sum() == pytest.approx(1.0)
    np.testing.assert_allclose(part @ CORNERS, point)


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_is_drawn_the_same_again(kind: str) -> None:
    one, other = (KINDS[kind](0.01, np.random.default_rng(4)) for _ in range(2))
    assert type(one) is type(other)
    assert repr(one) == repr(other)


def test_a_touching_rim_takes_load_once_it_touches() -> None:
    edge = Edge(0.5, 0, np.array([0.02, 0.045]), 3.0)
    little, much = np.full((1, 4), 2.9), np.full((1, 4), 5.0)
    np.testing.assert_allclose(edge.past(little, CORNERS), little)
    left = edge.past(much, CORNERS)
    assert left.sum() < much.sum()
    # What is missing acts where the rim touches.
    missing = (much - left)[0]
    np.testing.assert_allclose(missing @ CORNERS / missing.sum(), [0.02, 0.045])


def test_a_loose_plate_moves_the_load_and_takes_none_away() -> None:
    plate = LoosePlate(0.002, 0, 0.0, 4.0)
    load = np.concatenate([np.linspace(20.0, 30.0, 50), np.linspace(30.0, 20.0, 50)])
    forces = load[:, None] * shares(CORNERS, np.array([0.02, 0.0]))
    moved = plate.slid(forces, CORNERS)
    np.testing.assert_allclose(moved.sum(axis=1), load)
    cop = moved @ CORNERS / load[:, None]
    assert cop[49, 0] == pytest.approx(0.022)
    assert cop[-1, 0] == pytest.approx(0.018)


def test_a_hand_lets_go() -> None:
    hand = Hand.drawn(2.0, np.random.default_rng(1))
    assert hand.much(0.0) == 0.0
    middle = float(hand.starts[0] + hand.lengths[0] / 2.0)
    assert hand.much(middle) == pytest.approx(1.0)

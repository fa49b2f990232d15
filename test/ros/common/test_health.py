from __future__ import annotations

from ros.clock import Clock
from shoecal_core.errors import LONGEST
from shoecal_ros.common.health import Condition, Health, Level


def test_news_are_told_once() -> None:
    health = Health()
    health.tell("device", Level.OK, "reading")
    assert list(health.news()) == ["device"]
    health.tell("device", Level.OK, "reading", frames=3)
    assert health.news() == {}
    assert health.conditions["device"].values == {"frames": "3"}
    health.tell("device", Level.ERROR, "unplugged")
    assert health.news()["device"].message == "unplugged"


def test_a_number_that_grows_is_no_news() -> None:
    health = Health()
    health.tell("device", Level.ERROR, "no byte for 2.0 s")
    health.news()
    health.tell("device", Level.ERROR, "no byte for 13.1 s")
    assert health.news() == {}
    assert health.conditions["device"].message == "no byte for 13.1 s"


def test_a_worse_level_is_news() -> None:
    health = Health()
    health.tell("robot", Level.OK, "stands")
    health.news()
    health.tell("robot", Level.WARN, "stands")
    assert "robot" in health.news()


def test_the_last_error_stays_to_be_seen() -> None:
    clock = Clock()
    health = Health(clock)
    health.tell("device", Level.OK, "reading", frames=1)
    assert health.values("device") == {"frames": "1"}
    health.tell("device", Level.ERROR, "unplugged")
    clock.now += 5.0
    health.tell("device", Level.OK, "reading", frames=2)
    assert health.values("device") == {
        "frames": "2", "last_error": "unplugged", "last_error_age_s": "5",
    }  # fmt: skip


def test_what_a_peer_wrote_stays_one_line_of_bounded_length() -> None:
    health = Health()
    health.tell("device", Level.ERROR, "also from 'a\n[FATAL] falls\x1b[2J'", name="b\r\n\x00")
    condition = health.news()["device"]
    assert condition.message == "also from 'a [FATAL] falls\ufffd[2J'"
    assert condition.values == {"name": "b \ufffd"}
    health.tell("device", Level.ERROR, "x\n" * 500_000 + "; plug it in again")
    assert len(health.conditions["device"].message) <= LONGEST
    assert health.conditions["device"].message.endswith("plug it in again")
    assert "\n" not in health.values("device")["last_error"]
    health.suppose("peers", Condition(Level.OK, "y" * 10**6))
    assert len(health.conditions["peers"].message) <= LONGEST

from __future__ import annotations

import pytest

from ros.clock import Clock
from shoecal_core.errors import LONGEST, NameNotFoundError
from shoecal_ros.common.codes import Code, Problem, joined
from shoecal_ros.common.health import AGAIN_S, Condition, Health, Level


def test_news_are_told_once() -> None:
    health = Health()
    health.report("device", Level.OK, "reading")
    assert list(health.news()) == ["device"]
    health.report("device", Level.OK, "reading", frames=3)
    assert health.news() == {}
    assert health.conditions["device"].values == {"frames": "3"}
    health.report("device", Level.ERROR, "unplugged", Code.PORT_LOST)
    assert health.news()["device"].message == "unplugged"


def test_a_number_that_grows_is_no_news() -> None:
    health = Health()
    health.report("device", Level.ERROR, "no byte for 2.0 s", Code.PORT_SILENT)
    health.news()
    health.report("device", Level.ERROR, "no byte for 13.1 s", Code.PORT_SILENT)
    assert health.news() == {}
    assert health.conditions["device"].message == "no byte for 13.1 s"


def test_other_words_of_the_same_problem_wait_a_while() -> None:
    clock = Clock()
    health = Health(clock)
    told = []
    for fault in ("no packet", "checksum wrong", "no packet", "no end") * 25:
        clock.now += 0.1
        health.report("device", Level.ERROR, f"no good frame ({fault})", Code.PORT_UNREADABLE)
        told += [one.message for one in health.news().values()]
    assert len(told) == 2, told
    health.report("device", Level.ERROR, "no byte", Code.PORT_SILENT)
    assert "device" in health.news(), "another problem is told at once"
    health.report("device", Level.ERROR, "no byte at all", Code.PORT_SILENT)
    assert health.news() == {}
    clock.now += AGAIN_S
    assert health.news()["device"].message == "no byte at all", "the last words are told in the end"


def test_a_worse_level_is_news() -> None:
    health = Health()
    health.report("robot", Level.OK, "stands")
    health.news()
    health.report("robot", Level.WARN, "stands", Code.TRAJECTORY_REFUSED)
    assert "robot" in health.news()


def test_the_last_error_stays_to_be_seen() -> None:
    clock = Clock()
    health = Health(clock)
    health.report("device", Level.OK, "reading", frames=1)
    assert health.values("device") == {"code": "ok", "frames": "1"}
    health.report("device", Level.ERROR, "unplugged", Code.PORT_LOST)
    clock.now += 5.0
    health.report("device", Level.OK, "reading", frames=2)
    assert health.values("device") == {
        "code": "ok", "frames": "2", "last_error": "unplugged",
        "last_error_code": "port-lost", "last_error_age_s": "5",
    }  # fmt: skip


def test_what_a_peer_wrote_stays_one_line_of_bounded_length() -> None:
    health = Health()
    health.report(
        "device",
        Level.ERROR,
        "also from 'a\n[FATAL] falls\x1b[2J'",
        Code.SECOND_DRIVER,
        name="b\r\n\x00",
    )
    condition = health.news()["device"]
    assert condition.message == "also from 'a [FATAL] falls\ufffd[2J'"
    assert condition.values == {"name": "b \ufffd"}
    health.report("device", Level.ERROR, "x\n" * 500_000 + "; plug it in again", Code.PORT_LOST)
    assert len(health.conditions["device"].message) <= LONGEST
    assert health.conditions["device"].message.endswith("plug it in again")
    assert "\n" not in health.values("device")["last_error"]
    health.suppose("peers", Condition(Level.OK, "y" * 10**6))
    assert len(health.conditions["peers"].message) <= LONGEST


def test_another_code_of_the_same_words_is_news() -> None:
    health = Health()
    health.report("device", Level.ERROR, "lost", Code.PORT_LOST)
    health.news()
    health.report("device", Level.ERROR, "lost", Code.PORT_CLOSED)
    assert "device" in health.news()


@pytest.mark.parametrize(
    ("level", "code"), [(Level.WARN, Code.OK), (Level.ERROR, Code.OK), (Level.OK, Code.PORT_LOST)]
)
def test_what_is_wrong_has_a_code_and_nothing_else_has(level: Level, code: Code) -> None:
    with pytest.raises(ValueError, match=f"{level.name} with the code '{code}': x"):
        Condition(level, "x", code=code)


@pytest.mark.parametrize("code", ["", "ok", "Port", "port_lost", "port lost", "port-"])
def test_a_code_is_short_words_with_hyphens(code: str) -> None:
    with pytest.raises(ValueError, match="no code of a problem"):
        Problem(code, "x")


def test_a_problem_is_told_as_what_it_is() -> None:
    assert Condition.of(None, "reading").code == Code.OK
    reported = Condition.of(
        Problem.of(NameNotFoundError("cell", "x", ())), "reading", {"frames": "1"}
    )
    assert (reported.level, reported.code, reported.values) == (
        Level.ERROR,
        "name-not-found",
        {"frames": "1"},
    )
    assert reported.message == "no cell named 'x' (there are: none)"


def test_several_problems_have_the_code_of_the_first() -> None:
    several = Problem(Code.QOS_MISFIT, "a"), Problem(Code.TYPE_MISFIT, "b")
    assert joined(several) == Problem(Code.QOS_MISFIT, "a; b")
    assert joined([]) is None

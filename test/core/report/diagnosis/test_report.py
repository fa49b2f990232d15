from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from core.report import diagnoses
from core.report.pages import read
from core.robot import robots
from core.shoe import shoes
from shoecal_core.diagnosis import result
from shoecal_core.diagnosis.result import Diagnosis, Evidence, Fitted, NamedHypothesis, Size, Where
from shoecal_core.errors import FileError
from shoecal_core.report.diagnosis.report import diagnosis_page, write_diagnosis_report
from shoecal_core.report.html import render

NAO, SHOE = "nao", "nao_shoe"
HOSTILE = "<script>alert('$x$')</script> & \"b\""


@pytest.fixture(scope="module")
def evidence() -> Evidence:
    return diagnoses.evidence(count=100)


def slim(evidence: Evidence) -> Evidence:
    """Force and CoP alone, nothing found: the fewest figures."""

    def first(one: Fitted) -> Fitted:
        return Fitted(one.label, one.residuals[:, :3], one.contribution[:, :3])

    return replace(
        evidence, signals=evidence.signals[:3], noise=evidence.noise[:3],
        without=first(evidence.without), explained=None, rivals=(),
    )  # fmt: skip


def text_of(diagnosis: Diagnosis) -> str:
    page = diagnosis_page(diagnosis, robots.load(NAO), shoes.shoe(SHOE))
    return read(render(page)).text


def test_a_whole_report(tmp_path: Path, evidence: Evidence) -> None:
    path = tmp_path / "report.html"
    found = diagnoses.diagnosis(evidence)
    write_diagnosis_report(found, path, robot=robots.load(NAO), shoe=shoes.shoe(SHOE))
    html = path.read_text(encoding="utf-8")
    document = read(html)
    # Five on the feet, four signals, the ranking.
    assert document.tags["svg"] == 5 + 4 + 1
    assert path.stat().st_size < 3_000_000
    assert "script" not in document.tags
    assert not re.search(r"https?:", html)
    assert len(document.ids) == len(set(document.ids))
    titles = [
        "Where the gap lies", "Which cause", "What cannot be separated",
        "What this session could not show", "Before and after, on runs not used",
        "What to run next", "Notes",
    ]  # fmt: skip
    places = [document.text.rindex(title) for title in titles]
    assert places == sorted(places)


def test_the_answer_comes_first_in_plain_words() -> None:
    text = text_of(diagnoses.diagnosis())
    answer = text[: text.index("Where the gap lies")]
    assert "One explanation accounts for the gap." in answer
    assert "Found (93 % probable): left/front_left bends with load (nonlinearity): quad" in answer
    assert "quadratic 0.00410 1/N (95 %: 0.00369 to 0.00451)" in answer
    assert "CoP sideways at cell left/front_left (46 %)" in answer
    assert "shrinks by 94 % (95 % interval 88 to 97 %)" in answer
    assert "from 1.42 to 0.45 mm" in answer
    assert "Noise alone would leave 0.38 mm and 0.10 N" in answer


def test_an_improbable_cause_is_a_surmise() -> None:
    first = diagnoses.diagnosis().causes[0]
    likely, unlikely = replace(first, probability=0.6), replace(first, probability=0.29)
    text = text_of(diagnoses.diagnosis(causes=(first, likely, unlikely)))
    assert "And (60 % probable): left/front_left bends" in text
    assert "Perhaps also (29 % probable): left/front_left bends" in text
    assert "Perhaps (29 % probable): left/front_left bends" in text_of(
        diagnoses.diagnosis(causes=(unlikely,))
    )


def test_the_gap_is_told_with_its_spread(evidence: Evidence) -> None:
    rest = evidence.without.residuals[evidence.test]
    spread = np.nanstd(1e3 * np.linalg.norm(rest[:, 1:3], axis=1))
    assert f"1.42 ± {spread:.2f} mm" in text_of(diagnoses.diagnosis(evidence))
    assert (
        "±"
        not in diagnosis_page(diagnoses.diagnosis(), robots.load(NAO), shoes.shoe(SHOE))
        .key_figures[0]
        .value
    )


@pytest.mark.parametrize("verdict", get_args(result.Verdict))
def test_every_verdict_without_samples(verdict: result.Verdict) -> None:
    causes = () if verdict in {"no_gap", "unknown"} else diagnoses.diagnosis().causes
    text = text_of(diagnoses.diagnosis(None, verdict, causes=causes))
    assert verdict.replace("_", " ").capitalize() in text
    assert result.VERDICT_TEXTS[verdict][1:] in text
    assert ("Before and after" in text) == bool(causes)


def test_nothing_found_nothing_missing() -> None:
    text = text_of(
        diagnoses.diagnosis(
            diagnoses.evidence(count=60, empty=True), "no_gap", causes=(), ambiguity=(), where=(),
            ranking=(), next_motion=None, cannot_separate=(), cannot_detect=(), notes=(),
        )
    )  # fmt: skip
    assert "where a robot within tolerance has" in text
    assert "it can also separate" in text
    assert "would have shown in this session" in text
    assert "No further motion would separate the candidates" in text
    assert "Which cause" not in text


def test_nothing_in_the_library_explains_it() -> None:
    text = text_of(
        diagnoses.diagnosis(None, "unknown", causes=(), ambiguity=(), next_motion=None)
    )  # fmt: skip
    answer = text[: text.index("Where the gap lies")]
    assert "--effects-from" in answer
    assert "Probable as against each other only" in text
    assert "No further motion would separate the candidates" not in text


def test_what_is_simulated_is_told_first() -> None:
    page = diagnosis_page(
        diagnoses.diagnosis(), robots.load(NAO), shoes.shoe(SHOE), ("All of it is simulated.",)
    )  # fmt: skip
    text = read(render(page)).text
    assert text.index("All of it is simulated.") < text.index("Where the gap lies")


def test_confused_and_no_motion_that_would_help() -> None:
    alike = (
        NamedHypothesis("latency", ("left",), 0.6),
        NamedHypothesis("low_pass", ("left",), 0.4),
    )
    text = text_of(diagnoses.diagnosis(None, "ambiguous", ambiguity=alike, next_motion=None))
    assert "No motion was found that separates these candidates" in text


def test_what_cannot_be_told_apart_and_why() -> None:
    alike = (
        NamedHypothesis("latency", ("left",), 0.6),
        NamedHypothesis("low_pass", ("left",), 0.3),
    )
    found = diagnoses.diagnosis(
        None, "ambiguous",
        causes=(diagnoses.cause("latency", "timing", ("left",), 0.6, delay=(0.01, "s")),),
        ambiguity=alike, ranking=alike,
    )  # fmt: skip
    text = text_of(found)
    assert "In place of latency (left foot) it could as well be low pass (left foot)." in text
    assert "faster motion parts them" in text
    assert "as good as a chosen one" in text
    again = replace(found, cannot_separate=(*found.cannot_separate, tuple(
        one.label for one in reversed(alike))))  # fmt: skip
    assert text_of(again).count("faster motion parts them") == 1


def test_many_alike_and_many_blind_spots_in_few_rows() -> None:
    cells = [f"left/{index}" for index in range(6)]
    pairs = tuple((f"crosstalk (left/a, {cell})", f"cell_position ({cell})") for cell in cells)
    text = text_of(
        diagnoses.diagnosis(
            None, cannot_separate=pairs,
            cannot_detect=("creep of cells of the left foot (1 of 4 places: left/a)",
                           "link_com (2 of 25 places: Neck, Head)", "tether (1 of 1 places)",
                           "drifts with temperature: none was recorded", "floor_tilt"),
        )
    )  # fmt: skip
    assert text.count("exactly as that cell standing elsewhere") == 1
    assert "and 3 more" in text
    assert "of cells of the left foot (1 of 4 places: left/a)" in text
    assert "in the URDF 2 of 25 places: Neck, Head" in text
    assert "link com has its centre of mass" in text
    assert "drifts with temperature – none was recorded" in text
    assert "floor tilt is on a floor that is not level" in text


def test_two_causes_and_their_onset(evidence: Evidence) -> None:
    pair = (
        diagnoses.cause("latency", "timing", ("left",), 0.9, delay=(0.01, "s")),
        diagnoses.cause("slip", "contact", ("right",), 0.8, run=3, simulated=False,
                        dx=(0.004, "m"), time=(4.5, "s")),
    )  # fmt: skip
    found = diagnoses.diagnosis(slim(evidence), "partly_explained", causes=pair)
    html = render(diagnosis_page(found, robots.load(NAO), shoes.shoe(SHOE)))
    text = read(html).text
    assert "right foot slipped in run 3 (slip): dx" in text
    assert "the gap shrinks: the CoP's error from 1.42 to 0.45 mm" in text
    assert "slip (right foot), with the others 94 %" in text
    whole = replace(pair[0].shrink, fraction=0.55, ci95=(0.4, 0.6))
    text = text_of(diagnoses.diagnosis(None, "partly_explained", causes=pair, shrink=whole))
    assert "shrinks by 55 % (95 % interval 40 to 60 %)" in text
    assert ">4.5 s<" in html


def test_feet_with_six_axis_sensors_and_no_parity() -> None:
    origin = (0.0, 0.0, 0.05)
    shoe = shoes.made([*shoes.six_axis(0, origin), *shoes.six_axis(1, origin)])
    found = diagnoses.diagnosis(
        slim(diagnoses.evidence(shoe, count=60)),
        where=(Where("cop_x", "left", "left/fz", None, None, None, None, 0.4),
               Where("cop_y", "left", "left/mx", None, None, None, None, 0.2)),
    )  # fmt: skip
    html = render(diagnosis_page(found, robots.load(NAO), shoe))
    # Axes of one sensor stand at one place, with one share.
    assert ">60 %<" in html


def test_runs_with_gaps_and_signals_that_are_missing(evidence: Evidence) -> None:
    holes = evidence.without.residuals.copy()
    holes[40:90] = np.nan
    holes[:, evidence.signals.index("cop_x")] = np.nan
    partly = replace(
        evidence,
        without=replace(evidence.without, residuals=holes),
        test=np.zeros_like(evidence.test),
        rivals=evidence.rivals[:1],
    )
    text = text_of(diagnoses.diagnosis(partly, test=(), train=(1,)))
    assert "On the very runs that were fitted, for want of test runs," in text
    assert "There is no test run: these are errors on the runs that were fitted" in text
    assert "runs not used" not in text


def test_hostile_names_do_no_harm(evidence: Evidence) -> None:
    bad = replace(
        diagnoses.diagnosis().causes[0], effect=HOSTILE, group=HOSTILE, location=(HOSTILE,),
        size={HOSTILE: Size(1.0, HOSTILE, (0.0, 2.0))},
    )  # fmt: skip
    found = diagnoses.diagnosis(
        replace(slim(evidence), rivals=(replace(slim(evidence).without, label=HOSTILE),)),
        robot=HOSTILE, shoe=HOSTILE, notes=(HOSTILE,), cannot_detect=(HOSTILE,),
        causes=(bad,),
        ranking=(NamedHypothesis(HOSTILE, (HOSTILE,), 0.5),),
        where=(Where(HOSTILE, HOSTILE, None, HOSTILE, None, HOSTILE, None, 0.2),),
    )  # fmt: skip
    document = read(render(diagnosis_page(found, robots.load(NAO), shoes.shoe(SHOE))))
    assert "script" not in document.tags
    assert document.text.count("<script>alert('$x$')</script>") > 6


def test_the_same_diagnosis_is_the_same_bytes(evidence: Evidence) -> None:
    small = diagnoses.diagnosis(slim(evidence))
    pages = [
        render(diagnosis_page(small, robots.load(NAO), shoes.shoe(SHOE))) for _ in range(2)
    ]  # fmt: skip
    assert pages[0] == pages[1]


def test_no_folder_to_write_into(tmp_path: Path) -> None:
    taken = tmp_path / "file"
    taken.write_text("")
    with pytest.raises(FileError):
        write_diagnosis_report(
            diagnoses.diagnosis(), taken / "report.html", robot=robots.load(NAO),
            shoe=shoes.shoe(SHOE),
        )  # fmt: skip

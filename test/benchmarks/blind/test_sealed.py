"""The diagnosis cannot reach the answers, and the generator knows nothing of the diagnosis."""

from __future__ import annotations

import dataclasses
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from blind.answers import Answer, Foreign, Truth, check_seal, read_answers, seal
from blind.layout import PRIVATE, Round
from blind.submit import WORKER, Ledger, Submission, powerless, submit
from blind.world import draw_sections
from shoecal_core.errors import ShoecalError

BENCHMARKS = WORKER.parents[1]


def answer(number: int = 1) -> Answer:
    truth = Truth("latency", ("left",), {"delay": 0.02}, strength=3.0)
    return Answer(
        number, "single", 7, 101, (2, 0, 1), 1.0, imu=True,
        base="default", world=draw_sections(np.random.default_rng(1)), truths=(truth,),
        foreign=Foreign("cable", 5.0, 3, 1.5),
    )  # fmt: skip


def test_generator_and_baselines_never_import_the_diagnosis() -> None:
    program = (
        "import sys; sys.path.insert(0, sys.argv[1])\n"
        "import blind.generate, blind.unit_sizes, blind.baselines\n"
        "print(*[name for name in sys.modules if name.startswith('shoecal_core.diagnosis')])"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, str(BENCHMARKS)], capture_output=True, text=True, check=True
    )
    assert not done.stdout.split()


def test_answers_come_back_as_they_were_sealed(tmp_path: Path) -> None:
    place, answers = Round(tmp_path), [answer(1), answer(2)]
    digest = seal(place, answers)
    assert read_answers(place) == answers
    assert digest == check_seal(place) == place.seal.read_text().strip()
    assert place.sealed.stat().st_mode & 0o777 == PRIVATE


def test_a_round_keeps_its_answers(tmp_path: Path) -> None:
    place = Round(tmp_path)
    assert seal(place, [answer()]) == seal(place, [answer()])
    with pytest.raises(ShoecalError, match="another round's answers"):
        seal(place, [dataclasses.replace(answer(), seed=8)])


def test_answers_that_were_changed_are_refused(tmp_path: Path) -> None:
    place = Round(tmp_path)
    seal(place, [answer()])
    place.answers.write_text(place.answers.read_text().replace("0.02", "0.03"))
    with pytest.raises(ShoecalError, match="changed since it was sealed"):
        read_answers(place)


def test_a_second_submission_is_refused(tmp_path: Path) -> None:
    ledger, one = Ledger(tmp_path / "ledger.txt"), Submission(1, tmp_path)
    ledger.enter(one, b"{}")
    ledger.enter(dataclasses.replace(one, variant="without_tilt"), b"{}")
    with pytest.raises(ShoecalError, match="set 1 has been submitted"):
        ledger.enter(one, b"{}")


def ask(sealed: Path, *commands: list[str]) -> list[dict[str, object]]:
    """What a worker says to commands."""
    done = subprocess.run(
        [sys.executable, "-P", str(WORKER), str(sealed)],
        input="".join(json.dumps(command) + "\n" for command in commands),
        capture_output=True, text=True, check=True, cwd=sealed.parent,
    )  # fmt: skip
    return [json.loads(line) for line in done.stdout.splitlines()]


def test_the_worker_cannot_open_what_is_sealed(tmp_path: Path) -> None:
    place = Round(tmp_path / "round")
    seal(place, [answer()])
    (tmp_path / "way_round").symlink_to(place.sealed)
    said = ask(
        place.sealed,
        ["check", str(place.sealed)],
        ["recover", str(place.answers)],
        ["recover", str(tmp_path / "way_round" / "answers.json")],
    )
    assert all(one["code"] != 0 for one in said)
    assert all("is sealed" in str(one["error"]) for one in said[1:])


def test_the_worker_cannot_import_the_generator(tmp_path: Path) -> None:
    program = (
        "import runpy, sys\n"
        "from pathlib import Path\n"
        "worker = runpy.run_path(sys.argv[1])\n"
        "worker['shut_out'](Path(sys.argv[2]))\n"
        "sys.path.insert(0, sys.argv[3])\n"
        "import blind.generate\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, str(WORKER), str(tmp_path), str(BENCHMARKS)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode != 0
    assert "the diagnosis imports blind" in done.stderr


def test_what_fails_is_written_down_as_a_failure(tmp_path: Path) -> None:
    place = Round(tmp_path / "round")
    seal(place, [answer()])
    nowhere = Submission(1, tmp_path / "nowhere")
    submit(place, [nowhere], 1)
    told = json.loads(place.diagnosis(1).read_text())
    assert set(told) == {"error"}
    before = place.ledger.read_bytes()
    submit(place, [nowhere], 1)
    assert place.ledger.read_bytes() == before


@pytest.mark.skipif(not powerless(), reason="only root has powers to lose")
def test_without_its_powers_root_is_kept_out_by_the_folders_rights_alone(tmp_path: Path) -> None:
    place = Round(tmp_path)
    seal(place, [answer()])
    for program in ("open(sys.argv[1])", "os.chmod(os.path.dirname(sys.argv[1]), 0o777)"):
        done = subprocess.run(
            [*powerless(), sys.executable, "-c", f"import os, sys; {program}", str(place.answers)],
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert "PermissionError" in done.stderr

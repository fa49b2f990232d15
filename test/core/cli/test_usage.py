"""Wrong usage is told in one line, with what was meant; a shell completes what there is."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from core.cli.terminal import Terminal
from shoecal_core import cli
from shoecal_core.cli.completion_command import SHELLS, completion_script
from shoecal_core.cli.parsers import COMMANDS
from shoecal_core.cli.suggestions import nearest, nearest_file
from shoecal_core.error_sources.effects.known import EFFECTS
from shoecal_core.errors import FileError, NameNotFoundError, ShoecalError, error_code
from shoecal_core.planning.motion_catalogue import MOTION_KINDS
from shoecal_core.workspace import config_dir

NAO = str(config_dir() / "robots" / "nao.yaml")
SHOE = str(config_dir() / "shoes" / "nao_shoe.yaml")


def told(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """The one line of an error."""
    with contextlib.suppress(SystemExit):
        assert cli.main(words) == 1
    out, error = capsys.readouterr()
    assert not out
    (line,) = error.splitlines()
    return line


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        (("calibrte", "session"), "'calibrate'"),
        (("plan", NAO, "--out", "x", "--motion", "landmark"), "'landmarks'"),
        (("plan", NAO, "--out", "x", "--stance", "neutrl"), "'neutral'"),
        (("plan", NAO, "--out", "x", "--motin", "hold"), "'--motion'"),
        (("plan", NAO, "--out", "x", "--sed=3"), "'--seed'"),
        (("simulate", NAO, NAO, "--out", "x", "--motions", "hld"), "'hold'"),
        (("diagnose", "session", "--without", "tlt"), "'tilt'"),
        (("manual", "cell", "x"), "'cells'"),
    ],
)
def test_mistyped_names(
    capsys: pytest.CaptureFixture[str], words: tuple[str, ...], meant: str
) -> None:
    line = told(capsys, *words)
    assert f"did you mean {meant}? See shoecal" in line
    assert "choose from" not in line
    assert line.endswith("--help")


def test_what_looks_like_nothing_gets_no_guess(capsys: pytest.CaptureFixture[str]) -> None:
    line = told(capsys, "zzzzzz")
    assert "did you mean" not in line
    assert line.endswith("; see shoecal --help")
    assert not nearest("zzzzzz", COMMANDS)


def test_a_robot_may_be_meant_by_its_name(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    line = told(capsys, "plan", "nao", "--out", str(tmp_path / "plan"))
    assert line.endswith(f"did you mean '{NAO}'?")


def test_a_file_beside_the_one_that_is_not_there(tmp_path: Path) -> None:
    (tmp_path / "session").mkdir()
    (tmp_path / "session" / "shoe.yaml").touch()
    assert nearest_file(tmp_path / "sesion").endswith(f"'{tmp_path / 'session'}'?")
    inner = tmp_path / "sesion" / "shoe.yaml"
    assert nearest_file(inner).endswith(f"'{tmp_path / 'session' / 'shoe.yaml'}'?")
    assert not nearest_file(tmp_path / "sesion" / "other.yaml")
    assert not nearest_file(tmp_path / "session")
    assert not nearest_file(tmp_path / "qqqqqq" / "wwwwww" / "eeeeee")
    (tmp_path / "e.yaml").touch()
    assert not nearest_file(tmp_path / "none.yaml")
    assert nearest_file(tmp_path / "ee.yaml").endswith(f"'{tmp_path / 'e.yaml'}'?")


@pytest.mark.parametrize("missing", [0, 1, 2])
def test_what_a_list_names_itself_is_no_guess(tmp_path: Path, missing: int) -> None:
    files = [tmp_path / f"run_1_{part}.mcap" for part in range(3)]
    for file in files:
        file.touch()
    files[missing].unlink()
    assert nearest_file(files[missing])
    assert not nearest_file(files[missing], files)
    renamed = tmp_path / f"run_1_{missing} (1).mcap"
    renamed.touch()
    assert nearest_file(files[missing], files).endswith(f"'{renamed}'?")


def test_folders_that_a_list_names_are_no_guess(tmp_path: Path) -> None:
    named = [tmp_path / f"trial_{k}" / "joints.csv" for k in (1, 2)]
    named[0].parent.mkdir()
    named[0].touch()
    assert nearest_file(named[1])
    assert not nearest_file(named[1], named)


@pytest.mark.parametrize("words", [("plan", SHOE, "--shoe", NAO), ("simulate", SHOE, NAO)])
def test_robot_and_shoe_that_are_exchanged(
    capsys: pytest.CaptureFixture[str], words: tuple[str, ...]
) -> None:
    line = told(capsys, *words, "--out", "x")
    assert f"{SHOE} is the shoe file and {NAO} the robot file: exchange the two" in line


def test_a_folder_to_write_to_that_is_mistyped_gets_a_guess(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "out").mkdir()
    line = told(capsys, "diagnose", "x", "--report", str(tmp_path / "outt" / "report.html"))
    assert "make it first, for report.html" in line
    assert f"did you mean '{tmp_path / 'out'}'?" in line


def test_names_in_brackets_are_shown_as_they_are(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "[bold]a").mkdir()
    line = told(capsys, "check", str(tmp_path / "[bold]ab"))
    assert f"did you mean '{tmp_path / '[bold]a'}'?" in line


def test_help_tells_of_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        cli.main(["--help"])
    lines = capsys.readouterr().out.splitlines()
    for name, summary in COMMANDS.items():
        assert any(line.split()[:1] == [name] and summary[:20] in line for line in lines)


def test_help_names_files_that_exist(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for folder in (config_dir().parent, tmp_path):
        monkeypatch.chdir(folder)
        assert cli.main([]) == 2
        (line,) = (
            one for one in capsys.readouterr().err.splitlines() if "shoecal simulate " in one
        )
        _, _, robot, shoe, *_ = line.split()
        assert Path(robot).is_file()
        assert Path(shoe).is_file()


def test_without_its_files_help_names_none(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SHOECAL_CONFIG", str(tmp_path / "gone"))
    assert cli.main([]) == 2
    assert "shoecal simulate ROBOT.yaml SHOE.yaml" in capsys.readouterr().err


def test_without_a_command_help_is_told_as_an_error(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([]) == 2
    out, error = capsys.readouterr()
    assert not out
    assert "a first calibration" in error


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        cli.main(["--version"])
    assert ended.value.code == 0
    assert capsys.readouterr().out.startswith("shoecal ")


def test_help_tells_defaults(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        cli.main(["demo", "--help"])
    told = " ".join(capsys.readouterr().out.split())
    assert "--out DIR folder of the results (default: out/demo)" in told
    assert "draws robot, cells, supports (default: 1)" in told
    assert "(default: None)" not in told
    assert "(default: False)" not in told


@pytest.mark.parametrize("command", ["calibrate", "diagnose", "evaluate"])
def test_help_tells_no_empty_defaults(capsys: pytest.CaptureFixture[str], command: str) -> None:
    with pytest.raises(SystemExit):
        cli.main([command, "--help"])
    told = " ".join(capsys.readouterr().out.split())
    assert "--test R" in told
    assert "(default: ()" not in told
    assert "(default: []" not in told


def test_an_option_of_several_values_names_them(capsys: pytest.CaptureFixture[str]) -> None:
    line = told(capsys, "new", "robot", "a.urdf", "--sole", "0.1", "0.2", "0.1")
    assert "--sole: expected 5 arguments: BACK FRONT INNER OUTER HEIGHT; see" in line


def test_arguments_of_an_import_that_are_exchanged(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    mapping = tmp_path / "mapping.yaml"
    mapping.touch()
    line = told(capsys, "import", "bag", str(tmp_path), str(mapping), "--out", "session")
    assert f"{tmp_path}: is a folder, and {mapping} a file: name the mapping first" in line


@pytest.mark.parametrize("shell", SHELLS)
def test_completion_knows_commands_options_and_names(shell: str) -> None:
    script = completion_script(shell)
    for name in (*COMMANDS, *MOTION_KINDS, "--train", "--report"):
        assert name in script
    for effect in EFFECTS:
        assert effect.identifier in script


def test_without_its_package_completion_names_the_cure(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "shtab", None)
    assert told(capsys, "completion", "bash").endswith("pip install shtab")


def test_bash_completes(tmp_path: Path) -> None:
    script = tmp_path / "shoecal.bash"
    script.write_text(completion_script("bash"))

    def completed(*words: str) -> list[str]:
        told = " ".join(f"'{word}'" for word in words)
        program = (
            f"source '{script}'; COMP_WORDS=({told}); COMP_CWORD={len(words) - 1}; "
            '_shtab_shoecal; echo "${COMPREPLY[@]}"'
        )
        done = subprocess.run(
            ["bash", "--norc", "-c", program], capture_output=True, text=True, check=True
        )
        return done.stdout.split()

    assert completed("shoecal", "dia") == ["diagnose"]
    assert "--report" in completed("shoecal", "calibrate", "--re")
    assert completed("shoecal", "diagnose", "x", "--only", "cree") == ["creep"]
    assert completed("shoecal", "plan", "x", "--motion", "unload_l") == ["unload_left"]


def test_colours_only_on_a_terminal_that_wants_them(monkeypatch: pytest.MonkeyPatch) -> None:
    words = ("check", "/not/there")
    monkeypatch.delenv("NO_COLOR", raising=False)
    with Terminal(words) as terminal:
        terminal.until("does not exist")
        terminal.wait()
        assert b"\x1b[1;31m" in terminal._raw
    monkeypatch.setenv("NO_COLOR", "1")
    with Terminal(words) as terminal:
        terminal.until("does not exist")
        terminal.wait()
        assert b"31m" not in terminal._raw
    piped = subprocess.run(
        [sys.executable, "-m", "shoecal_core.cli", *words],
        capture_output=True, env={**os.environ, "TERM": "xterm"}, check=False,
    )  # fmt: skip
    assert b"\x1b" not in piped.stdout + piped.stderr
    assert piped.stdout == b""


def test_a_program_is_told_why(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    figures, robot = tmp_path / "figures.json", tmp_path / "robot.yaml"
    robot.write_text("format: 99\n")
    for name, code, file, field in (
        (str(robot), "version", str(robot), "format"),
        (str(tmp_path / "none.yaml"), "file-missing", str(tmp_path / "none.yaml"), ""),
    ):
        words = ("plan", name, "--shoe", SHOE, "--out", str(tmp_path / "out"))
        line = told(capsys, *words, "--json", str(figures))
        error = json.loads(figures.read_text())["error"]
        assert (error["code"], error["file"], error["field"]) == (code, file, field)
        assert error["message"] in line


def test_a_file_for_programs_that_cannot_be_written_is_told_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    line = told(capsys, "plan", "none.yaml", "--out", "x", "--json", str(tmp_path / "no" / "file"))
    assert "none.yaml" in line


def test_codes_of_errors() -> None:
    kinds = {FileError: "file", NameNotFoundError: "name-not-found", ShoecalError: "refused"}
    assert {kind: error_code(kind) for kind in kinds} == kinds

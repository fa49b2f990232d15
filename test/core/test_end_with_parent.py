from __future__ import annotations

import signal
import subprocess
import sys

from core.stranger import Stranger
from shoecal_core.end_with_parent import ending_with_parent

PARENT = """
import subprocess
from shoecal_core.end_with_parent import ending_with_parent
with subprocess.Popen(ending_with_parent(["sleep", "1000"])) as child:
    print(child.pid, flush=True)
"""


def test_it_ends_with_its_parent_that_is_killed() -> None:
    command = [sys.executable, "-c", PARENT]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None
        with Stranger(int(parent.stdout.readline())) as child:
            parent.kill()
            assert child.ends()


def test_it_does_not_begin_where_its_parent_has_ended() -> None:
    command = ending_with_parent(["echo", "here"])
    of_another = ["sh", "-c", '"$@"; exit $?', "sh", *command]
    done = subprocess.run(of_another, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (1, "")
    assert "not started: the process that asked for it" in done.stderr


def test_it_is_the_program_itself() -> None:
    command = ending_with_parent(["sh", "-c", "echo $$; kill -PIPE $$; echo 'is ignored'"])
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as program:
        assert program.stdout is not None
        assert program.stdout.read() == f"{program.pid}\n"
    assert program.returncode == -signal.SIGPIPE

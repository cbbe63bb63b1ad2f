"""A session of gmsh changes nothing of what the process does on signals, and ends whatever happens."""

import signal
import subprocess
import sys
from contextlib import suppress

import gmsh
import pytest

from rollbench.meshes.shell import RESET, gmsh_session

#: Sends this process what gmsh resets, in a session and after it, and counts what its own handlers are told.
PROGRAM = """
import os, signal
from rollbench.meshes.shell import RESET, gmsh_session
came, numbers = [], [getattr(signal, name) for name in RESET]
for number in numbers:
    signal.signal(number, lambda n, _: came.append(n))
with gmsh_session():
    for number in numbers:
        os.kill(os.getpid(), number)
for number in numbers:
    os.kill(os.getpid(), number)
assert came == 2 * numbers, came
"""


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="signals of Unix")
def test_signals_are_handled_as_before_in_a_session_and_after_it():
    """gmsh gives TERM back to the system: a command ended by it neither tidied up nor said so."""
    assert {"SIGTERM", "SIGHUP", "SIGPIPE"} <= set(RESET)
    done = subprocess.run([sys.executable, "-P", "-c", PROGRAM], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_a_session_ends_with_an_error_and_leaves_one_that_runs():
    with suppress(KeyError), gmsh_session({"Mesh.Optimize": 0}):
        assert gmsh.option.getNumber("Mesh.Optimize") == 0
        with gmsh_session():
            pass
        assert gmsh.isInitialized()
        raise KeyError
    assert not gmsh.isInitialized()


def test_a_session_prints_nothing(capfd):
    """gmsh writes to the process's standard output, where a command prints its answer or JSON."""
    with gmsh_session() as program:
        program.model.occ.addBox(0.0, 0.0, 0.0, 1.0, 1.0, 1.0)
        program.model.occ.synchronize()
        program.model.mesh.generate(3)
        assert program.model.mesh.getNodes()[0].size > 0
    assert capfd.readouterr() == ("", "")

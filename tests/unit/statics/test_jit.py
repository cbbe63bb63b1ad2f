"""Two engines from one source, and machine code that never outlives the sources it was made from."""

import os
import signal
import subprocess
import sys
from functools import partial

import pytest

from rollbench.lowfi import jit

CALL = "from rollbench.lowfi.jit import *; load_kernel_package(CONTACT, compiled=True); print(machine_code_folder())"


@pytest.fixture(autouse=True)
def fresh():
    """The module's cache as a new process finds it, before and after."""
    jit.machine_code_folder.cache_clear()
    yield
    jit.machine_code_folder.cache_clear()


def folder_now():
    jit.machine_code_folder.cache_clear()
    return jit.machine_code_folder()


def test_old_machine_code_goes(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    for number in range(6):
        old = tmp_path / "kernels" / f"old{number}"
        old.mkdir(parents=True)
        os.utime(old, (1000 + number, 1000 + number))
    folder, present = jit.machine_code_folder(), jit.digest_of_kernel_sources()
    assert folder == tmp_path / "kernels" / present
    assert {f.name for f in folder.parent.iterdir()} == {present, "old3", "old4", "old5"}
    assert not jit.is_machine_code_cached()
    (folder / jit.CONTACT / "kernel_1").mkdir(parents=True)
    (folder / jit.CONTACT / "kernel_1" / "f.nbi").write_text("machine code")
    cached = [jit.is_machine_code_cached(package) for package in ("", jit.CONTACT, jit.STATICS)]
    assert cached == [True, True, False]


def test_kernels_that_wait_for_the_answer_are_compiled_once(monkeypatch):
    monkeypatch.setattr(jit, "_afterwards", {})
    done = []
    for number in range(2):
        jit.register_compile_job(jit.CONTACT, lambda number=number: done.append(number))
    jit.run_compile_jobs()
    jit.run_compile_jobs()
    assert done == [1]


def test_machine_code_that_others_may_write_is_not_run(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    folder = jit.machine_code_folder()
    for place in (folder, folder.parent, folder.parents[1]):
        place.chmod(0o775)
        assert folder_now() is None
        error = capsys.readouterr().err
        assert str(place) in error
        assert "chmod go-w" in error
        place.chmod(0o755)
    assert folder_now() == folder


def test_without_a_folder_kernels_still_compile(tmp_path, monkeypatch, capfd):
    blocked = tmp_path / "file"
    blocked.write_text("no folder")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(blocked))
    assert jit.machine_code_folder() is None
    assert not jit.is_machine_code_cached()
    assert "compiled kernels are not stored" in capfd.readouterr().err
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    monkeypatch.setenv("ROLLBENCH_CACHE", "off")
    assert folder_now() is None
    assert capfd.readouterr().err == ""
    done = subprocess.run([sys.executable, "-c", CALL], capture_output=True, text=True, timeout=200, check=False)
    assert done.stdout.strip() == "None", done.stderr


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_waits_for_the_compiler(number, capsys, request):
    """It comes while the inner of two kernels is compiled, and ends the compilation of the outer."""
    import numba
    from numba.core import event

    def interrupt(*_):
        raise KeyboardInterrupt

    class Interrupting(event.Listener):
        def on_start(self, event):
            compiled.append(event.data["dispatcher"])
            if compiled[-1] is inner:
                signal.raise_signal(number)

        def on_end(self, _):
            pass

    compiled = []
    inner = numba.njit(lambda x: x + 1.0)
    outer = numba.njit(lambda x: 2.0 * inner(x))
    jit._delay_signals_while_compiling()
    request.addfinalizer(partial(signal.signal, number, signal.signal(number, interrupt)))
    with event.install_listener("numba:compile", Interrupting()), pytest.raises(KeyboardInterrupt):
        outer(1.0)
    assert signal.getsignal(number) is interrupt
    assert "interrupted" in capsys.readouterr().err
    assert compiled == [outer, inner]
    assert (len(outer.signatures), len(inner.signatures)) == (0, 1)
    assert outer(1.0) == 4.0


def test_one_solve_compiles_nothing_from_an_empty_home(tmp_path):
    clean = {k: v for k, v in os.environ.items() if k not in ("NUMBA_CACHE_DIR", "ROLLBENCH_CACHE", "XDG_CACHE_HOME")}
    command = [sys.executable, "-X", "importtime", "-m", "rollbench", "solve", "lin-case1", "--json"]
    there = {**clean, "HOME": str(tmp_path)}
    done = subprocess.run(command, capture_output=True, text=True, timeout=200, check=True, env=there)
    assert '"status": "converged"' in done.stdout
    imported = {line.rpartition("|")[2].strip() for line in done.stderr.splitlines()}
    assert "rollbench.lowfi.statics.kernel" in imported
    assert "numba" not in imported
    assert not [*tmp_path.rglob("*.nb?")]

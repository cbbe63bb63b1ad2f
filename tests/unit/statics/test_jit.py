"""Two engines from one source, and machine code that never outlives the sources it was made from."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from lowfi import jit

CALL = "from lowfi import jit; k = jit.kernels(jit.CONTACT, compiled=True); print(jit.code_folder())"


@pytest.fixture(autouse=True)
def fresh():
    """Caches of the module as a new process finds them, before and after."""
    jit.code_folder.cache_clear()
    yield
    jit.code_folder.cache_clear()


def test_machine_code_is_filed_by_the_sources(tmp_path, monkeypatch):
    shutil.copytree(Path(jit.__file__).parent, tmp_path / "lowfi", ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(jit, "__file__", str(tmp_path / "lowfi" / "jit.py"))
    found, changed = [jit.digest.__wrapped__()], 0
    for package in jit.PACKAGES:
        folder = tmp_path.joinpath(*package.split("."))
        for source in (folder / "__init__.py", *folder.parent.glob("records.py")):
            source.write_text(source.read_text() + "# changed\n")
            found.append(jit.digest.__wrapped__())
            changed += 1
    assert len(set(found)) == changed + 1 > len(jit.PACKAGES)


def test_checkouts_compile_from_one_copy_of_their_sources(tmp_path, monkeypatch):
    """numba files machine code by the path of its source: two checkouts of the same kernels name the same one."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    found = [jit._sources(jit.CONTACT)]
    shutil.copytree(Path(jit.__file__).parent, tmp_path / "lowfi", ignore=shutil.ignore_patterns("__pycache__"))
    with monkeypatch.context() as elsewhere:
        elsewhere.setattr(jit, "__file__", str(tmp_path / "lowfi" / "jit.py"))
        jit.code_folder.cache_clear()
        found.append(jit._sources(jit.CONTACT))
    assert found[0] == found[1]
    assert found[0].is_relative_to(tmp_path / "cache" / "kernels" / jit.digest())
    assert jit._contents(found[0]) == jit._contents(jit._folder(jit.CONTACT))
    (found[0] / "motion.py").write_text("# damaged\n")
    assert jit._sources(jit.CONTACT) == jit._folder(jit.CONTACT)


def test_old_machine_code_goes(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    for number in range(6):
        old = tmp_path / "kernels" / f"old{number}"
        old.mkdir(parents=True)
        os.utime(old, (1000 + number, 1000 + number))
    folder = jit.code_folder()
    assert folder == tmp_path / "kernels" / jit.digest()
    assert sorted(f.name for f in folder.parent.iterdir()) == sorted([jit.digest(), "old3", "old4", "old5"])
    assert not jit.cached()
    (folder / "f.nbi").write_text("machine code")
    assert jit.cached()


def test_without_a_folder_kernels_still_compile(tmp_path, monkeypatch, capfd):
    blocked = tmp_path / "file"
    blocked.write_text("no folder")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(blocked))
    with monkeypatch.context() as patched:
        patched.setattr(jit, "_private", lambda: blocked / "private")
        assert jit.code_folder() is None
        assert not jit.cached()
        assert "compiled kernels are not kept" in capfd.readouterr().err
    jit.code_folder.cache_clear()
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    monkeypatch.setenv("ROLLBENCH_CACHE", "off")
    assert jit.code_folder() is None
    assert capfd.readouterr().err == ""
    done = subprocess.run([sys.executable, "-c", CALL], capture_output=True, text=True, timeout=200, check=False)
    assert done.stdout.strip() == "None", done.stderr


@pytest.mark.parametrize("package", jit.PACKAGES)
def test_both_engines_hold_the_same_kernels(package):
    plain, compiled = (jit.kernels(package, compiled=c) for c in (False, True))
    assert jit.loaded(package)
    names = plain.__all__
    assert compiled.__all__ == names
    functions = [name for name in names if callable(getattr(plain, name))]
    assert all(hasattr(getattr(compiled, name), "py_func") for name in functions)
    assert not any(hasattr(getattr(plain, name), "py_func") for name in functions)
    assert jit.kernels(package, compiled=False) is plain


def test_an_unknown_package_is_refused():
    with pytest.raises(KeyError):
        jit.kernels("lowfi.nothing", compiled=True)

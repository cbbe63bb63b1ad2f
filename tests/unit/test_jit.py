"""Cached machine code never outlives the sources it was made from."""

from lowfi.jit import compiled, drop_stale, interpreted


def test_machine_code_of_changed_sources_is_dropped(tmp_path):
    (tmp_path / "a.py").write_text("x = 1\n")
    assert drop_stale(tmp_path)
    cached = tmp_path / "__pycache__" / "f.nbi"
    cached.write_text("machine code")
    assert not drop_stale(tmp_path)
    assert cached.exists()
    (tmp_path / "b.py").write_text("y = 2\n")
    assert drop_stale(tmp_path)
    assert not cached.exists()


def test_machine_code_made_with_older_sources_goes(tmp_path):
    used, folder = tmp_path / "used", tmp_path / "own"
    used.mkdir()
    folder.mkdir()
    (used / "a.py").write_text("x = 1\n")
    assert drop_stale(folder, used)
    old = folder / "__pycache__" / "f.nbc"
    old.write_bytes(b"machine code")
    assert not drop_stale(folder, used)
    assert old.exists()
    (used / "a.py").write_text("x = 2\n")
    assert drop_stale(folder, used)
    assert not old.exists()


def test_both_engines_hold_the_same_kernels():
    names = interpreted().__all__
    assert compiled().__all__ == names
    assert all(hasattr(getattr(compiled(), name), "py_func") for name in names)
    assert not any(hasattr(getattr(interpreted(), name), "py_func") for name in names)

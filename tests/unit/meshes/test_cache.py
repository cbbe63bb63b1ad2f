"""Cached records: the same again, never another recipe's, never damaged, whatever happens to the files."""

import hashlib
import io
import multiprocessing
import os
import pickle
import resource
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
import scipy.sparse as sp
from skfem import MeshTet, MeshTet2

from rollbench.meshes import cache as module
from rollbench.meshes.cache import Cache, cached_on_disk, key_of_result, record_from_bytes, record_to_bytes
from rollbench.meshes.files import create_private_folder


@dataclass(frozen=True)
class Inner:
    name: str
    points: np.ndarray


@dataclass(frozen=True)
class Record:
    value: object


@dataclass(frozen=True)
class Recipe:
    sizes: np.ndarray
    inner: Inner
    options: dict


RECIPE = Recipe(np.linspace(0.0, 1.0, 3000), Inner("a", np.eye(3)), {"b": 1, "a": 2})
SPARSE = sp.random(30, 20, 0.2, random_state=1, format="csr")


def never(build):
    """The same builder by name, which must not be called."""

    @wraps(build, updated=())
    def fail(*_):
        raise AssertionError("built again")

    return fail


def record(_: int = 1) -> Record:
    return Record((np.arange(5.0), {"a": SPARSE}, "x"))


def numbers(count: int) -> Record:
    return Record(np.arange(count))


def answers(store: Cache, build=record, number: int = 1) -> None:
    """Assert that the cache has that record, whole."""
    found, expected = store.get(build, (number,), Record).value, record().value
    np.testing.assert_array_equal(found[0], expected[0])
    assert (found[1]["a"] != expected[1]["a"]).nnz == 0
    assert found[2] == expected[2]


def built_anew(root: Path) -> None:
    """Assert that the record is made where its file is no good, and kept."""
    answers(Cache(root))
    answers(Cache(root), never(record))


def stored(folder: Path) -> list[Path]:
    return sorted(folder.rglob("*.npz"))


def test_a_record_comes_back(tmp_path: Path):
    first = Cache(tmp_path)
    answers(first)
    again = Cache(tmp_path)
    answers(again, never(record))
    assert (first.hits, first.misses, again.hits, again.misses) == (0, 1, 1, 0)
    assert len(stored(tmp_path)) == 1


@pytest.mark.parametrize(
    "value", [np.float64(0.1), np.bool_(True), np.int64(-3), np.str_("a"), range(2, 9, 3), {(1, "a"): None}]
)
@pytest.mark.parametrize("compressed", [False, True])
def test_a_plain_value_comes_back_with_its_type(value, compressed):
    found = record_from_bytes(record_to_bytes(value, compressed=compressed))
    assert (found, type(found)) == (value, type(value))


def test_a_mesh_comes_back_with_its_names_and_another_class_is_refused(tmp_path: Path):
    mesh = MeshTet2.from_mesh(MeshTet()).with_boundaries({"end": np.array([0, 1])}).with_subdomains({"all": np.arange(5)})
    Cache(tmp_path).get(Record, (mesh,), Record)
    found = Cache(tmp_path).get(never(Record), (mesh,), Record).value
    np.testing.assert_array_equal(found.doflocs, mesh.doflocs)
    np.testing.assert_array_equal(found.boundaries["end"], [0, 1])
    np.testing.assert_array_equal(found.subdomains["all"], np.arange(5))
    with pytest.raises(TypeError, match="returned a float, not a Record"):
        Cache(tmp_path).get(float, (1,), Record)


def test_key_covers_builder_arguments_class_versions_and_sources(monkeypatch):
    steel, equal = (Inner("steel", np.eye(3)) for _ in range(2))
    same = (((steel, steel), (steel, equal)), (({"a": 1, "b": 3.0},), ({"b": 3, "a": 1},)))
    for one, other in same:
        assert key_of_result(record, one, Record) == key_of_result(record, other, Record)
    given = ((record, (RECIPE,), Record), (numbers, (RECIPE,), Record), (record, (RECIPE, None), Record))
    keys = {key_of_result(*one) for one in (*given, (record, (RECIPE,), Inner))}
    assert len(keys) == 4
    told = {"_installed_version": ("gmsh", "scikit-fem", "rollbench"), "digest_of_sources": ("rollbench.meshes", "tests")}
    for of, package in [(of, package) for of, packages in told.items() for package in packages]:
        real = getattr(module, of)
        with monkeypatch.context() as patch:
            patch.setattr(module, of, lambda name, p=package, real=real: "0.0" if name == p else real(name))
            assert key_of_result(record, (RECIPE,), Record) not in keys


def test_a_builder_without_a_name_of_its_own_is_refused(tmp_path: Path):
    for build, given, why in ((lambda: record(), (), "not defined at module"), (record, (print,), "no canonical text")):
        with pytest.raises(TypeError, match=why):
            Cache(tmp_path).get(build, given, Record)


def test_sources_of_a_package_are_digested(monkeypatch, tmp_path: Path):
    (tmp_path / "grown").mkdir()
    monkeypatch.syspath_prepend(str(tmp_path))

    def digest(name: str, text: str, time: float = 1.0) -> str:
        (tmp_path / "grown" / name).write_text(text)
        os.utime(tmp_path / "grown" / name, (time, time))
        module.digest_of_sources.cache_clear()
        return module.digest_of_sources("grown")

    files = ("__init__.py", "x = 1"), ("__init__.py", "x = 2"), ("more.py", "x = 2"), ("more.py", "")
    assert len({digest(*file) for file in (*files, files[-1])}) == 4
    later = module._BEGAN + 1.0  # changed while running: shared with nobody
    assert digest("more.py", "", later) != digest("more.py", "", later)
    module.digest_of_sources.cache_clear()


def test_a_killed_writer_leaves_nothing_that_is_read(tmp_path: Path, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(Path, "replace", Mock(side_effect=KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            answers(Cache(tmp_path))
    assert stored(tmp_path) == []
    built_anew(tmp_path)


def compete(folder: str, number: int) -> None:
    """Write and read the same records as other processes do, again and again; the first one removes them."""
    for size in range(1000, 1020):
        found = Cache(Path(folder)).get(numbers, (size,), Record)
        assert np.array_equal(found.value, np.arange(size))
        for file in Path(folder).rglob("*.npz") if number == 0 else ():
            file.unlink(missing_ok=True)


def test_writers_at_the_same_time_do_not_disturb_each_other(tmp_path: Path):
    context = multiprocessing.get_context("spawn")
    workers = [context.Process(target=compete, args=(str(tmp_path), k)) for k in range(2)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join(120)
    assert [worker.exitcode for worker in workers] == [0, 0]


def test_a_folder_that_cannot_be_written_is_reported_once(tmp_path: Path, capsys):
    (tmp_path / "file").write_text("")
    store = Cache(tmp_path / "file" / "cache")
    for k in range(3):
        answers(store, number=k)
    error = capsys.readouterr().err
    assert error.count("continues without the cache") == error.count("\n") == 1
    assert store.misses == 3


def test_a_full_disc_is_reported_and_harmless(tmp_path: Path, capsys):
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, hard))
    try:
        store = Cache(tmp_path)
        for k in range(2):
            assert store.get(numbers, (100_000 + k,), Record).value.size == 100_000 + k
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert capsys.readouterr().err.count("too large") == 1
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []


@pytest.mark.parametrize("place", [".", "records"])
@pytest.mark.parametrize("mode", [0o777, 0o770])
def test_a_folder_that_others_may_write_to_is_not_used(place: str, mode: int, tmp_path: Path, capsys):
    root = tmp_path / "cache"
    Cache(root).get(record, (1,), Record)
    (root / place).chmod(mode)
    again = Cache(root)
    answers(again)
    assert (again.hits, again.misses) == (0, 1)
    error = capsys.readouterr().err
    assert error.count("chmod go-w") == error.count("\n") == 1


def test_a_folder_of_another_user_is_not_used_but_one_that_all_share_may_be_the_root(tmp_path: Path, monkeypatch, capsys):
    root = tmp_path / "cache"
    answers(Cache(root))
    with monkeypatch.context() as patch:
        patch.setattr(os, "getuid", lambda: 4711)
        answers(Cache(root))
    assert "belongs to another user" in capsys.readouterr().err
    tmp_path.chmod(0o1777)
    assert create_private_folder(tmp_path, "mine").stat().st_mode & 0o777 == 0o700
    (tmp_path / "link").symlink_to(tmp_path)
    with pytest.raises(PermissionError):
        create_private_folder(tmp_path, "link")


def described(tree: str) -> bytes:
    """A description without arrays, as records are packed."""
    stream = io.BytesIO()
    np.savez(stream, np.frombuffer(tree.encode(), np.uint8))
    return stream.getvalue()


def digested(content: bytes) -> bytes:
    """Content of a file that took a second to make, behind the digest that it must have."""
    timed = module._SECONDS.pack(1.0) + content
    return hashlib.sha256(timed).digest() + timed


class Evil:
    def __reduce__(self):
        return os.mkdir, ("executed",)


def test_what_is_damaged_or_no_record_is_built_anew_and_nothing_in_a_file_is_run(tmp_path: Path, monkeypatch, capsys):
    """Cut off, with a bit flipped, other than its digest, or behind its digest and yet no record."""
    monkeypatch.chdir(tmp_path)
    root, stream = tmp_path / "cache", io.BytesIO()
    answers(Cache(root))
    (file,) = stored(root)
    whole = file.read_bytes()
    flipped = [whole[:k] + bytes([whole[k] ^ 0x41]) + whole[k + 1 :] for k in range(0, len(whole), 37)]
    damaged = [*(whole[:length] for length in (0, 1, 30, len(whole) // 2, len(whole) - 1)), b"other", *flipped]
    np.savez(stream, np.array([Evil()], dtype=object))
    evil = [pickle.dumps(Evil()), stream.getvalue(), described('["record", "os:mkdir", {"path": "executed"}]')]
    trees = ('["array", 9]', '["record"]', '["none"]', "[]", '["dict", 1]', "{", 20_000 * "[")
    sparse = '["sparse", "scipy.sparse:csr_matrix", [1], 1, 2, 3]'
    no_record = [b"", b"PK\x03\x04 no archive", *map(described, (*trees, sparse))]
    for content in (*damaged, *evil, *map(digested, (*evil, *no_record))):
        file.write_bytes(content)
        built_anew(root)
    assert capsys.readouterr().err == ""
    assert not (tmp_path / "executed").exists()


calls: list[int] = []


@cached_on_disk(Record)
def kept(size: int) -> Record:
    calls.append(size)
    return Record(size)


def test_geometries_are_kept_between_commands_only_when_switched_on(tmp_path, monkeypatch):
    monkeypatch.setenv("ROLLBENCH_CACHE", str(tmp_path))
    assert kept(5) == Record(5)
    assert not list(tmp_path.iterdir())
    module.switch_on_geometry_cache()
    try:
        assert kept(4) == kept(4) == Record(4)
        assert calls == [5, 4]
    finally:
        module._stores.clear()


def several(arguments) -> list[Record]:
    calls.append([number for (number,) in arguments])
    return [Record(number) for (number,) in arguments]


def test_results_of_several_arguments_are_kept_each_and_the_missing_ones_made_in_one_call(tmp_path):
    calls.clear()
    store = Cache(tmp_path)
    assert store.get_each(several, [(1,), (2,)], Record) == [Record(1), Record(2)]
    assert store.get_each(several, [(3,), (1,), (4,)], Record) == [Record(3), Record(1), Record(4)]
    assert Cache(tmp_path).get_each(several, [(4,), (2,)], Record) == [Record(4), Record(2)]
    assert calls == [[1, 2], [3, 4]]
    assert (store.hits, store.misses) == (1, 4)
    assert Cache(None).get_each(several, [(5,), (1,)], Record) == [Record(5), Record(1)]

"""Cached records: bit for bit the same, never another recipe's, never damaged, whatever happens to the files."""

import multiprocessing
import os
import resource
import struct
import zipfile
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp

from meshes import cache as module
from meshes.cache import Cache, default_root, key_of


@dataclass(frozen=True)
class Inner:
    name: str
    points: np.ndarray


@dataclass(frozen=True)
class Record:
    value: object


@dataclass(frozen=True)
class Socket:
    xi: np.ndarray
    edges: dict[tuple[int, int], int]


@dataclass(frozen=True)
class Body:
    points: np.ndarray
    sockets: dict[int, Socket | None]
    seconds: float


@dataclass(frozen=True)
class Recipe:
    sizes: np.ndarray
    inner: Inner
    options: dict
    edge: float = 0.1
    count: int = 3
    note: str | None = None
    pair: tuple = (1, 0.0)


RECIPE = Recipe(np.linspace(0.0, 1.0, 3000), Inner("a", np.eye(3)), {"b": 1, "a": 2})
SPARSE = sp.random(30, 20, 0.2, random_state=1, format="csr")


def fail():
    raise AssertionError("built again")


def stored(folder: Path) -> list[Path]:
    return sorted(folder.glob("*.npz"))


def same(a: object, b: object) -> None:
    """Assert that two values have the same types and the same bits."""
    assert type(a) is type(b)
    if isinstance(a, np.ndarray | np.generic):
        assert a.dtype.str == b.dtype.str
        assert a.shape == b.shape
        assert a.tobytes() == b.tobytes()
        if isinstance(a, np.ndarray) and a.ndim > 1:
            assert a.flags.f_contiguous == b.flags.f_contiguous
    elif sp.issparse(a):
        assert a.shape == b.shape
        for name in module._SPARSE[a.format]:
            same(getattr(a, name), getattr(b, name))
        assert (a != b).nnz == 0
    elif isinstance(a, float):
        assert struct.pack("d", a) == struct.pack("d", b)
    elif isinstance(a, tuple | list):
        assert len(a) == len(b)
        for x, y in zip(a, b, strict=True):
            same(x, y)
    elif isinstance(a, dict):
        same(list(a.items()), list(b.items()))
    elif hasattr(a, "__dataclass_fields__"):
        same(vars(a), vars(b))
    else:
        assert a == b


WIDE = sp.csr_matrix((3, 4))
WIDE.data, WIDE.indices, WIDE.indptr = np.array([2.5]), np.array([3]), np.array([0, 1, 1, 1])
VALUES = {
    "float array": np.array([0.1, -0.0, np.nan, np.inf, 5e-324, np.nextafter(1.0, 2.0)]),
    "fortran order": np.asfortranarray(np.arange(6.0).reshape(2, 3)),
    "strided": np.arange(20)[::3],
    "types": (np.arange(3, dtype=">i2"), np.ones(2, bool), np.array([1 + 2j]), np.array(["ä", "bc"]), np.float32([0.1])),
    "empty": (np.empty((0, 3)), np.array(2.5), np.array([], dtype=np.int64)),
    "numpy scalars": (np.float64(0.1), np.int32(-3), np.bool_(True), np.str_("x")),
    "numbers": (1, 10**40, True, 0.1, -0.0, float("nan"), float("-inf"), 1j, -2.0 + 0.5j, None, "", "ü\n\ud800", b"\x00z"),
    "containers": ((), [], {}, (1, (2, [3, {"a": (4,)}])), {3: "c", "a": 1, (0, 1): 2.0, None: None}),
    "csr": SPARSE,
    "csc": SPARSE.tocsc(),
    "coo": SPARSE.tocoo(),
    "bsr": SPARSE.tobsr(blocksize=(3, 2)),
    "dia": sp.diags_array([np.arange(4.0), np.ones(3)], offsets=[0, 1]),
    "sparse array": sp.csr_array(SPARSE),
    "csr of 64-bit indices": WIDE,
    "empty sparse": sp.csc_matrix((4, 0)),
    "nested": Inner("ö", np.eye(2)),
    "mesh": Body(
        np.random.default_rng(1).random((5, 3)), {0: Socket(np.eye(3), {(0, 1): 3, (1, 2): 4}), 2: None}, 0.25
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", VALUES)
def test_round_trip_is_bit_for_bit(name, tmp_path: Path):
    value = Record(VALUES[name])
    Cache(tmp_path).get("thing", name, lambda: value, Record)
    again = Cache(tmp_path)
    same(again.get("thing", name, fail, Record), value)
    assert (again.hits, again.misses) == (1, 0)


def test_files_are_plain_npz_without_pickles(tmp_path: Path):
    Cache(tmp_path).get("thing", 1, lambda: Record((np.eye(3), "x")), Record)
    (file,) = stored(tmp_path)
    with np.load(file, allow_pickle=False) as content:
        assert content.files == ["structure", "array0", "checksum"]
        np.testing.assert_array_equal(content["array0"], np.eye(3))


@pytest.mark.parametrize(
    "value",
    [
        np.array([object()]), {1, 2}, object(), print, np.zeros(2, [("a", float)]), np.ma.array([1.0]), Path("x"),
        sp.lil_matrix((2, 2)), Record,
    ],
    ids=lambda v: type(v).__name__,
)  # fmt: skip
def test_other_types_are_refused(value, tmp_path: Path):
    with pytest.raises(TypeError, match="cannot hold"):
        Cache(tmp_path).get("thing", 1, lambda: Record(value), Record)
    with pytest.raises(TypeError, match="cannot hold"):
        key_of("thing", value, Record)
    assert list(tmp_path.iterdir()) == []


def test_a_field_outside_the_constructor_is_refused(tmp_path: Path):
    @dataclass(frozen=True)
    class Odd:
        x: float = field(default=1.0, init=False)

    with pytest.raises(TypeError, match="not set by its constructor"):
        Cache(tmp_path).get("thing", 1, Odd, Odd)
    with pytest.raises(TypeError, match="built a float, not a Record"):
        Cache(tmp_path).get("thing", 1, lambda: 1.0, Record)


def moved(array: np.ndarray, place: int) -> np.ndarray:
    out = array.copy()
    out[place] = np.nextafter(out[place], np.inf)
    return out


CHANGES = {
    "one ulp in the middle": replace(RECIPE, sizes=moved(RECIPE.sizes, 1500)),
    "shape": replace(RECIPE, sizes=RECIPE.sizes[None]),
    "type": replace(RECIPE, sizes=RECIPE.sizes.view(np.int64)),
    "nested array": replace(RECIPE, inner=Inner("a", -np.eye(3))),
    "sign of zero": replace(RECIPE, pair=(1, -0.0)),
    "nested string": replace(RECIPE, inner=Inner("b", np.eye(3))),
    "float": replace(RECIPE, edge=float(np.nextafter(0.1, 1.0))),
    "int": replace(RECIPE, count=4),
    "float for int": replace(RECIPE, count=3.0),
    "none": replace(RECIPE, note=""),
    "tuple": replace(RECIPE, pair=(1, 0.0, None)),
    "list": replace(RECIPE, pair=[1, 0.0]),
    "dict value": replace(RECIPE, options={"b": 2, "a": 2}),
    "dict key": replace(RECIPE, options={"b": 1, "c": 2}),
    "without its class": vars(RECIPE),
}


@pytest.mark.parametrize("name", CHANGES)
def test_any_change_changes_the_key(name, monkeypatch):
    monkeypatch.setattr(module, "sources", lambda name: f"code of {name}")
    key = key_of("thing", RECIPE, Record)
    assert key == key_of("thing", replace(RECIPE, sizes=RECIPE.sizes.copy()), Record)
    assert key_of("thing", CHANGES[name], Record) != key


def test_key_covers_kind_class_versions_and_sources(monkeypatch):
    monkeypatch.setattr(module, "sources", lambda name: f"code of {name}")
    key = key_of("thing", RECIPE, Record)
    assert key_of("thing", RECIPE, Record) == key
    assert key_of("other", RECIPE, Record) != key
    assert key_of("thing", RECIPE, Inner) != key
    assert key_of("thing", (0.0,), Record) != key_of("thing", (-0.0,), Record)
    assert key_of("thing", {"a": 1, 2: 3}, Record) == key_of("thing", {2: 3, "a": 1}, Record)
    f = np.arange(6.0).reshape(2, 3)
    assert key_of("thing", f, Record) == key_of("thing", np.asfortranarray(f), Record) != key_of("thing", f.T, Record)
    assert key_of("thing", VALUES["types"], Record) != key_of("thing", VALUES["empty"], Record)
    real = module.metadata.version
    for package in ("gmsh", "rollbench"):
        with monkeypatch.context() as patch:
            patch.setattr(module.metadata, "version", lambda name, p=package: "0.0" if name == p else real(name))
            assert key_of("thing", RECIPE, Record) != key
    for package in ("meshes", "tests"):
        with monkeypatch.context() as patch:
            patch.setattr(module, "sources", lambda name, p=package: f"{'new ' * (name == p)}code of {name}")
            assert key_of("thing", RECIPE, Record) != key
    monkeypatch.setattr(module, "SCHEMA", 2)
    assert key_of("thing", RECIPE, Record) != key


def test_sources_of_a_package_are_digested(monkeypatch, tmp_path: Path):
    (tmp_path / "grown").mkdir()
    monkeypatch.syspath_prepend(str(tmp_path))

    def digest(name: str, text: str, time: float = 1.0) -> str:
        (tmp_path / "grown" / name).write_text(text)
        os.utime(tmp_path / "grown" / name, (time, time))
        module.sources.cache_clear()
        return module.sources("grown")

    first = digest("__init__.py", "x = 1")
    assert digest("__init__.py", "x = 1", 2.0) == first
    assert len({first, digest("__init__.py", "x = 2"), digest("more.py", "x = 2"), digest("more.py", "")}) == 4
    later = module._BEGAN + 1.0  # changed while running: shared with nobody
    assert digest("more.py", "", later) != digest("more.py", "", later)
    assert module.sources("builtins") == ""
    module.sources.cache_clear()


@pytest.mark.parametrize("kind", ["", "../x", "a b", "Body", "a/b", "ä"])
def test_kinds_are_words(kind):
    with pytest.raises(ValueError, match="kind"):
        key_of(kind, 1, Record)


def record() -> Record:
    return Record((np.arange(5.0), {"a": SPARSE}, "x"))


def damaged_is_rebuilt(folder: Path, file: Path) -> None:
    """The next reader builds again, the one after reads what was built."""
    again = Cache(folder)
    same(again.get("thing", 1, record, Record), record())
    assert (again.hits, again.misses) == (0, 1)
    same(Cache(folder).get("thing", 1, fail, Record), record())
    assert [p.name for p in folder.iterdir()] == [file.name]


def test_truncated_files_are_rebuilt(tmp_path: Path):
    Cache(tmp_path).get("thing", 1, record, Record)
    (file,) = stored(tmp_path)
    whole = file.read_bytes()
    for length in (0, 1, 30, 100, len(whole) // 2, len(whole) - 100, len(whole) - 22, len(whole) - 1):
        file.write_bytes(whole[:length])
        damaged_is_rebuilt(tmp_path, file)
    assert file.read_bytes() == whole


def test_a_flipped_byte_never_gives_another_record(tmp_path: Path):
    Cache(tmp_path).get("thing", 1, lambda: Record((np.arange(3.0), np.arange(2), "x")), Record)
    (file,) = stored(tmp_path)
    whole = file.read_bytes()
    key = file.stem.removeprefix("thing-")
    refused = 0
    for place in range(len(whole)):
        file.write_bytes(whole[:place] + bytes([whole[place] ^ 0x41]) + whole[place + 1 :])
        found = module._load(file, key, Record)
        if found is None:
            refused += 1
        else:  # dates and flags of the zip's directory
            same(found.value, (np.arange(3.0), np.arange(2), "x"))
    assert refused > 0.7 * len(whole)


def rewritten(file: Path, change) -> None:
    """The file as a valid zip with other contents under the same names."""
    with np.load(file) as content:
        arrays = dict(content)
    change(arrays)
    with file.open("wb") as out:
        np.savez(out, **arrays)


@pytest.mark.parametrize(
    "change",
    [
        lambda a: a.update(array0=a["array0"][:-1]),
        lambda a: a.update(array0=a["array0"].reshape(1, -1)),
        lambda a: a.update(array0=a["array0"].astype(np.float32)),
        lambda a: a.update(array0=moved(a["array0"], 2)),
        lambda a: a.update(array3=a["array2"]),
        lambda a: a.update(structure=np.frombuffer(b'"other"', np.uint8)),
        lambda a: a.pop("array3"),
        lambda a: a.pop("checksum"),
        lambda a: a.update(checksum=np.zeros(32, np.uint8)),
        lambda a: a.update(checksum=np.zeros(0, np.uint8)),
        lambda a: a.clear(),
    ],
)
def test_valid_archives_of_other_content_are_rebuilt(change, tmp_path: Path):
    Cache(tmp_path).get("thing", 1, record, Record)
    (file,) = stored(tmp_path)
    rewritten(file, change)
    assert zipfile.is_zipfile(file)
    damaged_is_rebuilt(tmp_path, file)


called = []


def note() -> None:
    called.append(1)


def test_foreign_files_are_rebuilt(tmp_path: Path):
    store = Cache(tmp_path)
    store.get("thing", 2, lambda: Record("of another recipe"), Record)
    (other,) = stored(tmp_path)
    file = tmp_path / f"thing-{key_of('thing', 1, Record)}.npz"
    other.rename(file)
    damaged_is_rebuilt(tmp_path, file)
    file.write_bytes(b"no archive")
    damaged_is_rebuilt(tmp_path, file)
    with np.load(file) as content, file.with_suffix(".tmp").open("wb") as out:
        np.savez_compressed(out, **content)  # might unpack to anything: not even read
    file.with_suffix(".tmp").rename(file)
    damaged_is_rebuilt(tmp_path, file)
    module._store(file, file.stem.removeprefix("thing-"), f'["record","{__name__}:note",{{}}]'.encode(), [])
    damaged_is_rebuilt(tmp_path, file)
    assert called == []
    module._store(file, file.stem.removeprefix("thing-"), b'"no record"', [])
    damaged_is_rebuilt(tmp_path, file)


def test_an_interrupted_writer_leaves_nothing(tmp_path: Path, monkeypatch):
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(module.os, "replace", interrupt)
    with pytest.raises(KeyboardInterrupt):
        Cache(tmp_path).get("thing", 1, record, Record)
    assert list(tmp_path.iterdir()) == []


def compete(folder: str, number: int, queue) -> None:
    """Write and read the same records as other processes do, again and again."""
    for turn in range(30):
        size = 1000 + turn
        found = Cache(Path(folder)).get("thing", turn, lambda size=size: Record(np.arange(size)), Record)
        if not np.array_equal(found.value, np.arange(size)):
            queue.put(f"{number}: wrong at {turn}")
        if number == 0:
            for file in Path(folder).glob("*.npz"):
                file.unlink(missing_ok=True)
    queue.put("done")


def test_writers_at_the_same_time_do_not_disturb_each_other(tmp_path: Path):
    context = multiprocessing.get_context("spawn")
    queue = context.Queue()
    workers = [context.Process(target=compete, args=(str(tmp_path), k, queue)) for k in range(3)]
    for worker in workers:
        worker.start()
    answers = [queue.get(timeout=60) for _ in workers]
    for worker in workers:
        worker.join(60)
    assert answers == ["done"] * 3
    assert all(file.suffix == ".npz" for file in tmp_path.iterdir())
    for file in stored(tmp_path):
        assert module._load(file, file.stem.removeprefix("thing-"), Record) is not None


def test_a_folder_that_cannot_be_written_is_reported_once(tmp_path: Path, capsys):
    (tmp_path / "file").write_text("")
    store = Cache(tmp_path / "file" / "cache")
    for k in range(3):
        same(store.get("thing", k, record, Record), record())
    error = capsys.readouterr().err
    assert error.count("going on without it") == error.count("\n") == 1
    assert store.misses == 3


def test_a_read_only_folder_still_answers(tmp_path: Path, capsys, monkeypatch):
    Cache(tmp_path).get("thing", 1, record, Record)

    def refuse(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(module.tempfile, "mkstemp", refuse)
    monkeypatch.setattr(module.os, "utime", refuse)
    store = Cache(tmp_path)
    same(store.get("thing", 1, fail, Record), record())
    store.get("thing", 2, record, Record)
    store.get("thing", 3, record, Record)
    assert capsys.readouterr().err.count("Permission denied") == 1


def test_a_full_disc_leaves_nothing(tmp_path: Path, capsys):
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, hard))
    try:
        store = Cache(tmp_path)
        for k in range(2):
            found = store.get("thing", k, lambda: Record(np.arange(100_000)), Record)
            assert found.value.size == 100_000
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert capsys.readouterr().err.count("too large") == 1
    assert list(tmp_path.iterdir()) == []


def test_those_used_longest_ago_go_first(tmp_path: Path):
    store = Cache(tmp_path, limit=30_000)
    for k in range(3):
        store.get("thing", k, lambda: Record(np.zeros(1000)), Record)
        os.utime(tmp_path / f"thing-{key_of('thing', k, Record)}.npz", (k + 1.0, k + 1.0))
    old = tmp_path / ".thing.tmp"
    young = tmp_path / ".other.tmp"
    for file in (old, young):
        file.write_text("")
    os.utime(old, (1.0, 1.0))
    store.get("thing", 0, fail, Record)  # used: now the youngest
    store.get("thing", 3, lambda: Record(np.zeros(1000)), Record)
    left = {file.stem.removeprefix("thing-") for file in stored(tmp_path)}
    assert left == {key_of("thing", k, Record) for k in (0, 2, 3)}
    assert young.exists()
    assert not old.exists()
    store.get("thing", 4, lambda: Record(np.zeros(4000)), Record)  # more than the cache holds: not kept
    assert {file.stem.removeprefix("thing-") for file in stored(tmp_path)} == left


def test_files_that_another_process_drops_meanwhile(tmp_path: Path, monkeypatch):
    store = Cache(tmp_path)
    for k in range(3):
        store.get("thing", k, record, Record)
    first, *_ = stored(tmp_path)
    real = Path.stat

    def stat(self: Path, **options) -> os.stat_result:
        """The first file is gone before it is looked at, the others just after."""
        if self == first:
            os.unlink(self)
        found = real(self, **options)
        if self.suffix == ".npz":
            os.unlink(self)
        return found

    store.limit = 1
    with monkeypatch.context() as patch:
        patch.setattr(Path, "stat", stat)
        store._prune()
    assert stored(tmp_path) == []


def test_switched_off_and_default_folder(tmp_path: Path, monkeypatch):
    store = Cache(None)
    assert [store.get("thing", 1, lambda k=k: Record(k), Record).value for k in (1, 2)] == [1, 2]
    assert (store.hits, store.misses) == (0, 2)
    monkeypatch.setenv("ROLLBENCH_CACHE", str(tmp_path / "here"))
    assert default_root() == tmp_path / "here"
    monkeypatch.setenv("ROLLBENCH_CACHE", "off")
    assert default_root() is None
    monkeypatch.delenv("ROLLBENCH_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert default_root().name == "rollbench"

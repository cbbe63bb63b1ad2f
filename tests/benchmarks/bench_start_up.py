"""What people wait for at the start: ``pytest -n 0 tests/benchmarks/bench_start_up.py``. Each is a process of its own."""

import pytest
from tests.processes import python


@pytest.mark.parametrize(
    "words", ["--help", "list", "solve lin-case1", "solve lin-case1 --model lin", "friction lin-case1"]
)
def test_a_command_as_typed(benchmark, words, tmp_path):
    def typed():
        return python("-m", "rollbench", *words.split(), cwd=tmp_path)

    assert benchmark.pedantic(typed, rounds=3, warmup_rounds=1).returncode == 0


@pytest.mark.parametrize("engine", ["interpreted", "compiled"])
def test_a_first_solve_with_an_empty_cache(benchmark, engine, tmp_path):
    numbers = iter(range(10))
    code = (
        "from rollbench.compare.scenes.catalogue import scene\n"
        "from rollbench.lowfi.statics.static import solve_static\n"
        f"solve_static(scene('lin-case1'), engine={engine!r})"
    )

    def first():
        cache = str(tmp_path / f"cache{next(numbers)}")
        return python("-c", code, cwd=tmp_path, environ={"ROLLBENCH_CACHE": cache, "NUMBA_CACHE_DIR": cache})

    assert benchmark.pedantic(first, rounds=1).returncode == 0

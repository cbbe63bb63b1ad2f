"""Linear algebra on one thread at the end of each kind of command, in its workers and, by its switch, of the library."""

import json
import os
import shlex

import pytest
from tests.processes import python

from rollbench.meshes.processes import VARIABLES

pytestmark = pytest.mark.slow

UNSET = {name: value for name, value in os.environ.items() if name not in VARIABLES}
COUNT = """
import atexit, json, sys
def count():
    from threadpoolctl import threadpool_info
    found = [x["num_threads"] for x in threadpool_info() if x["user_api"] == "blas"]
    print(json.dumps(found), file=sys.__stderr__)
atexit.register(count)
"""
COMMAND = f"{COUNT}\nfrom rollbench.compare.cli import main\nmain()\n"
LIN = ("solve", "lin-case1", "--model", "lin")


def threads(code, *words, cwd, **variables):
    """Threads of each library of linear algebra that a process has loaded at its end."""
    done = python("-c", code, *words, cwd=cwd, env={**UNSET, **variables})
    assert done.returncode == 0, done.stderr
    return json.loads(done.stderr.splitlines()[-1])


SEVERAL_CORES = pytest.mark.skipif(os.cpu_count() == 1, reason="with one core every library has one thread")


KINDS = [
    shlex.join(LIN),
    "compare lin-case1",
    "export two-balls nut --out nut.vtu",
    "sweep lin-case1-cut --vary 'errors.balls.oversize=1 um:3 um' --samples 8 --model lin",
    pytest.param("compare lin-case1-cut --levels 1 --fresh", marks=pytest.mark.slow),
]


@SEVERAL_CORES
@pytest.mark.parametrize("words", KINDS)
def test_each_kind_of_command_ends_with_one_thread(words, tmp_path):
    assert set(threads(COMMAND, *shlex.split(words), cwd=tmp_path)) == {1}


@SEVERAL_CORES
def test_workers_have_one_thread_each_and_share_the_work(tmp_path):
    code = (
        f"{COUNT}\nimport numpy\nfrom threadpoolctl import threadpool_info\n"
        "from rollbench.compare.reference.parallel import run_jobs\n"
        "for _, found in run_jobs([(threadpool_info, ())] * 2, workers=2):\n"
        "    print([x['num_threads'] for x in found if x['user_api'] == 'blas'])\n"
    )
    done = python("-c", code, cwd=tmp_path, env=UNSET)
    assert set(done.stdout.split("\n")) == {"[1]", ""}, done.stderr


def test_a_users_own_variable_wins(tmp_path):
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        assert set(threads(COMMAND, *LIN, cwd=tmp_path, **{name: "2"})) == {2}


def test_a_call_of_the_library_has_one_thread_and_leaves_the_rest_to_its_user(tmp_path):
    code = (
        f"{COUNT}\nimport numpy, rollbench\nfrom rollbench.lowfi.statics import settle\n"
        "settled = settle.solve_with_updated_contacts\n"
        "def counted(*given, **named):\n    count()\n    return settled(*given, **named)\n"
        "settle.solve_with_updated_contacts = counted\nrollbench.solve('lin-case1', 'lin')\n"
    )

    def inside_and_after(**variables):
        done = python("-c", code, cwd=tmp_path, env={**UNSET, **variables})
        return [set(json.loads(line)) for line in (done.stderr.splitlines()[0], done.stderr.splitlines()[-1])]

    assert inside_and_after() == [{1}, {os.cpu_count()}]
    assert inside_and_after(OPENBLAS_NUM_THREADS="2") == [{2}, {2}]

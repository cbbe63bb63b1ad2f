"""How many functions of the package stand between a scene's name and the solver."""

from tests.copies import ROOT
from tests.processes import python

#: Prints how many different functions of the package run from ``rollbench.solve(NAME)`` to the first call of a solver.
COUNTED = """
import functools, os, sys
import rollbench

seen, real = set(), functools.cache(os.path.realpath)
package = tuple(os.path.join(sys.argv[2], part, "") for part in ("src", "lowfi", "hifi", "meshes", "compare", "reports"))

def watch(frame, event, _):
    code = frame.f_code
    if event != "call" or not real(code.co_filename).startswith(package):
        return
    if code.co_name == "solve_elastic":
        sys.setprofile(None)
        raise KeyboardInterrupt
    if code.co_flags & 2 and not code.co_name.startswith("<"):  # no bodies of modules and classes, no comprehensions
        seen.add(code)

sys.setprofile(watch)
try:
    rollbench.solve(sys.argv[1])
except KeyboardInterrupt:
    print(len(seen))
"""


def test_few_functions_stand_between_a_scene_and_its_solver(tmp_path):
    """In a new process, with the functions that run at import; 0.15.0 had 170, of which half is allowed."""
    done = python("-c", COUNTED, "unseen-40x10", str(ROOT), cwd=tmp_path, environ={"PYTHONPATH": str(ROOT / "src")})
    assert int(done.stdout) <= 170 // 2

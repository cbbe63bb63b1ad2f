"""What the test command without options leaves out: further tests, what is slow, and nothing else."""

import tomllib

import pytest
from tests.conftest import TESTS
from tests.copies import ROOT
from tests.processes import python

MARKED = "import pytest\ndef test_plain(): pass\n" + "".join(
    "".join(f"@pytest.mark.{mark}\n" for mark in marks) + f"def test_{'_of_'.join(marks)}(): pass\n"
    for marks in (("slow",), ("slow", "every_run"), ("survey",), ("installs",))
)
#: Options, and the tests that they run: of one solve (c), of a study (w), through a helper (h) and of a case (s).
RUNS = {
    "": "c-plain c-slow_of_every_run h-slow_of_every_run s-slow_of_every_run w-slow_of_every_run",
    "tests/test_w.py": "w-plain w-slow w-slow_of_every_run",
    "-m further and not slow": "h-installs h-plain h-survey s-installs s-plain s-survey w-installs w-plain w-survey",
}


@pytest.fixture(scope="module")
def marked(tmp_path_factory):
    """A small tree with the options and the conftest of this one."""
    root = tmp_path_factory.mktemp("marked")
    options = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["pytest"]["ini_options"]
    lines = [f"{key} = {value!r}" for key, value in options.items() if key not in ("pythonpath", "filterwarnings")]
    (root / "pyproject.toml").write_text("\n".join(["[tool.pytest.ini_options]", *lines]) + "\n", encoding="utf-8")
    texts = {
        "conftest.py": (TESTS / "conftest.py").read_text(encoding="utf-8"),
        "helper.py": "from rollbench.lowfi.friction import contact\n",
        "test_c.py": '"""Tells of rollbench.compare.studies.sweep and imports none."""\n' + MARKED,
        "test_h.py": "if False:\n    pass\n" + "from tests.helper import contact\n" + MARKED,
        "test_w.py": MARKED + "\ndef imports():\n    from rollbench.compare.studies import sweep\n",
        "sources/lin/test_s.py": MARKED,
    }
    for name, text in texts.items():
        (root / "tests" / name).parent.mkdir(parents=True, exist_ok=True)
        (root / "tests" / name).write_text(text, encoding="utf-8")
    return root


@pytest.mark.parametrize("options", RUNS)
def test_a_command_runs_what_its_marks_say(marked, options: str) -> None:
    words = ["-m", options.removeprefix("-m ")] if options.startswith("-m") else options.split()
    command = "-m", "pytest", "-n0", "-vv", "-p", "no:cacheprovider", "-p", "no:rollbench", *words
    done = python(*command, cwd=marked, env={"PYTHONPATH": f"{marked}:{ROOT / 'src'}", "PATH": ""})
    run = [line.partition(" PASSED")[0].partition("test_")[2] for line in done.stdout.splitlines() if " PASSED" in line]
    assert " ".join(sorted(one.replace(".py::test_", "-") for one in run)) == RUNS[options], done.stdout + done.stderr

"""The former name of the package `rollbench.compare`, and the former function of that name."""

import importlib
import subprocess
import sys

import pytest

import rollbench


def test_the_former_name_gives_the_same_modules_with_a_warning():
    program = (
        "import warnings\n"
        "with warnings.catch_warnings(record=True) as seen:\n"
        "    warnings.simplefilter('always')\n"
        "    from rollbench.comparison.models.registry import MODELS as former\n"
        "    import rollbench.comparison\n"
        "from rollbench.compare.models.registry import MODELS\n"
        "import rollbench.compare\n"
        "assert former is MODELS and rollbench.comparison is rollbench.compare\n"
        "print([str(w.message) for w in seen if 'will be removed' in str(w.message)])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("rollbench.comparison will be removed in the next version") == 1


def test_the_former_function_names_its_successor():
    assert importlib.import_module("rollbench.compare") is rollbench.compare
    with pytest.raises(TypeError, match="compare_models"):
        rollbench.compare("lin-case1")

"""Constants of all modules of physics, and defaults of their records and functions: thresholds, sizes of meshes and bounds
that no answer shows at once, of wings (as `rollbench.lowfi.friction`) too. They guard against change, as those beside them.

Whoever changes them on purpose writes them again with ``python -m tests.golden.test_constants`` and says why in the commit.
"""

import json
import subprocess
import sys
from contextlib import suppress
from importlib import import_module
from inspect import getmembers, isclass, isfunction, signature
from pathlib import Path

import numpy as np
import pytest
from tests.golden.means import leaves
from tests.mutants.draw import dotted, modules
from tests.mutants.run import ROOT

RECORD = Path(__file__).parent / "constants.json"


def numbers(module):
    """Of a module's constants, and of the defaults of its functions, records and their methods."""
    members = vars(module)
    kinds = [kind for kind in members.values() if isclass(kind) and kind.__module__ == module.__name__]
    called = [f for place in (module, *kinds) for _, f in getmembers(place, isfunction) if f.__module__ == module.__name__]
    defaults = [parameter.default for f in called for parameter in signature(f).parameters.values()]
    found = leaves([[value for name, value in members.items() if name.isupper()], defaults], lambda _: False)
    return [float(f"{x:.9g}") for _, values in found for x in np.ravel(values) if np.isfinite(x)]


def constants():
    found = {}
    for name in map(dotted, modules()):
        with suppress(ImportError):  # one kernel is loaded for a system only
            found[name] = numbers(import_module(name))
    return {name: values for name, values in found.items() if values}


@pytest.mark.slow
def test_no_constant_of_physics_moves():
    """In a process of its own: other tests set some of them."""
    program = "import json\nfrom tests.golden.test_constants import constants\nprint(json.dumps(constants()))"
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True)
    assert json.loads(done.stdout) == json.loads(RECORD.read_text(encoding="utf-8"))


if __name__ == "__main__":
    lines = [f"{json.dumps(name)}: {json.dumps(own)}" for name, own in constants().items()]
    RECORD.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")

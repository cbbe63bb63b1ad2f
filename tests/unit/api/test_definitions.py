"""Every number of the output is defined, and every definition is of a number that some command prints."""

import pytest
from tests.shipped_texts import changed

from rollbench.compare.results.definitions import _definitions_by_path_pattern, definition
from rollbench.compare.scenes.catalogue import shipped_scene_text
from rollbench.compare.scenes.template import commented_template

pytestmark = pytest.mark.slow

#: Keys that number, name or count, in tables whose headings say what they are.
NO_QUANTITY = (
    *("index", "member", "members", "seed", "set", "level", "levels[]", "converged", "contacts", "seconds", "ball"),
    *("load_kN", "values[]", "printed", "value", "reference", "reference_error", "error_percent", "station_mm"),
    *("screw", "nut", "schema"),
)


def leaves(value: object, path: str = ""):
    """Paths and values of all that an answer holds."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from leaves(inner, f"{path}.{key}".lstrip("."))
    elif isinstance(value, (list, tuple)):
        for inner in value:
            yield from leaves(inner, f"{path}[]")
    else:
        yield path, value


COMMANDS = """
solve lin-case1
solve double-nut
compare lin-case1
solve lin-case3 --stiffness-at 400_mm
solve lin-random --members 3 --balls
friction lin-case3 --mu 0.1
friction lin-case1 --mu 0.1
friction smith-axis-taper
check lin-case1 --no-compute --limit angle=1
solve lin-case1 --curve=-300N:300N:3
table lin-case3 --over load=1_kN,2_kN --quantities stiffness,displacement,load,preload,pressure,life
"""


#: Of an axis: what its motor turns, and a bearing whose life nothing gives.
AXIS = '[drive]\nmass = "200 kg"\ntime = "0.1 s"\n[motion]'


def test_every_number_is_defined_and_every_definition_is_of_something_printed(command, tmp_path):
    one, two = (shipped_scene_text(name) for name in ("lin-case1", "double-nut"))
    scenes = {
        "lin": f'{one}\n[[cases]]\nname = "case1"\nshare = 1\n',  # its only case has the stored runs of lin-case1
        "step": f'{one}\n[ingredients]\nload_step = "100 N"\n',
        "operation": f"{one}\n[operation]\nreliability = 95\nviscosity_ratio = 1.5\ncontamination = 0.6\n",
        "axis": shipped_scene_text("axis-fixed-fixed").replace("[motion]", AXIS),
        "turning": f'{one}\n[motion]\nspeed = "60 rpm"\n',
        "bearings": commented_template("support-bearings"),
        "rollers": changed("rollers", ('warming = "10 K"', 'warming = "0 K"')),
        "deep-groove": changed("public/b1-nptel-clearance"),
        "sets": f'{two}\n[[cases]]\nname = "one"\nshare = 1\n',
    }
    for name, text in scenes.items():
        (tmp_path / f"{name}.toml").write_text(text)
    commands = COMMANDS.strip().splitlines()
    commands += [f"{word} {tmp_path}/lin.toml" for word in ("friction", "compare", "check --no-compute")]
    commands += [f"solve {tmp_path}/{name}.toml" for name in scenes]
    commands.append(f"solve {tmp_path}/axis.toml {tmp_path}/rollers.toml")
    printed = []
    for line in commands:
        words = [word.replace("_mm", " mm").replace("_kN", " kN") for word in line.split()]
        model = "liu" if "step.toml" in line else "lin"
        printed += leaves(command.json(*words, "--model", model, "--json")[1])
    numbers = {path for path, value in printed if isinstance(value, (int, float)) and not isinstance(value, bool)}
    assert not sorted(path for path in numbers if definition(path) is None and path.rsplit(".")[-1] not in NO_QUANTITY)
    paths = {path for path, _ in printed}
    assert not [pattern.pattern for pattern, _ in _definitions_by_path_pattern() if not any(map(pattern.fullmatch, paths))]

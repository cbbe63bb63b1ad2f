"""What wings and sources add to the core. The core finds their registrations here and names none of them.

A wing (``compare/wings/NAME``) is what a user may leave out, a source (``compare/sources/NAME``) what one publication
printed. Each says in its ``registration.py`` what it adds, functions as ``module:function`` in words, so that nothing of it
is imported before it is called. Where a folder is absent, or one that it needs, nothing of it is there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module, resources
from pathlib import Path
from typing import Any

from rollbench.compare.errors import InputError

#: The folder of this package.
ROOT = Path(str(resources.files("rollbench.compare")))


@dataclass(frozen=True)
class Part:
    """A section of the report by name: its module in ``compare``; quick: stands in a quick report too; runs: shows
    runs of the 3D reference; meshes: needs gmsh; meshed: what of it needs gmsh, where the rest does not; page: on which it
    stands, named in `commands.reporting.parts`; needs: wings without which it is left out."""

    name: str
    module: str
    quick: bool = False
    runs: bool = False
    meshes: bool = False
    meshed: str = ""
    page: str = "outside"
    needs: tuple[str, ...] = ()


@dataclass(frozen=True)
class Registration:
    """What a wing or a source adds. Modules are named below ``rollbench.compare``, functions as ``module:function``.

    folders: of the repository, which belong to it beside its own; needs: wings without which it is not there;
    commands: module by name of the command, which adds it to the command line;
    kinds: record of ``scenes.kinds.Kind`` by kind of scene; parts: sections of the report; functions: by a name of `HOOKS`.
    """

    folders: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()
    commands: Mapping[str, str] = field(default_factory=dict)
    kinds: Mapping[str, str] = field(default_factory=dict)
    parts: tuple[Part, ...] = ()
    functions: Mapping[str, str] = field(default_factory=dict)


#: What the core asks of wings and sources, by name: what it calls, and what that returns.
HOOKS = {
    "bench": "(): jobs of rollbench bench",
    "conformity": "(parts of a set, preload [N], rigidity [N/m] of a pair): conformity of its grooves",
    "deck": "(program, unit, balls, b over h, growth, stiffness, scene, file): the answer of rollbench export on a deck",
    "friction": "(scene, result, options): JSON-ready sums of friction of a static result, or None and why",
    "friction of a scene": "(scene, coefficients, model): JSON-ready answer on a scene of any kind",
    "friction of a page": "(scene, result, options): section on the friction of one's own screw, or None",
    "outside": "(study): number of outside values, bias and scatter as cells of columns, by quantity",
    "ensemble": "(scene, model, count, seed, workers, step): JSON-ready statistics of a scene with random errors",
    "members": "(scene, model, count, file of rows, seed, engine, balls): the answer of rollbench solve --members",
    "mesh study": "(scene, levels, step, spread, store): of rollbench.mesh_study: JSON-ready, what is shown, lines",
    "other program": "(): (its name, loads (n, 4) [N] by scene) of another program's runs",
    "references": "(fresh): names of scenes and mesh levels whose runs the report shows",
    "rolling compare": "(names, levels, store, engine, fresh, bodies): the answer of rollbench compare on rolling balls",
    "rolling study": "(names, levels, store, engine, source, fresh, bodies): the same of rollbench mesh-study",
    "circuit faults": "(scene): faults of a circulation that cannot be built",
    "run times": "(study, step): tables and figures for the report's section on the reference",
    "starting torque": "(parts of a bearing, thrust [N]): its torque by Palmgren's load formula",
    "stability": "(): texts and tables for the report's section on stability",
    "sweep": "(scene, vary, samples, method, model, seed, folder, outputs, step): JSON-ready summary of a sweep",
    "timing": "(step): tables for the report's section on run times",
    "timing jobs": "(): further jobs of that section",
    "torque": "(sets with results, friction, motion, options): friction torque of all sets [N mm], or None",
}


#: What cases add to the report and to benches.
OF_CASES = {
    "of lin": Registration(
        parts=(
            Part("hertz", "cases.lin.pages.hertz", page="reference"),
            Part("cases", "cases.lin.pages.cases", quick=True, runs=True, page="cases"),
            Part("reconstruction", "cases.lin.pages.reconstruction", runs=True, page="cases"),
            Part("errors", "cases.lin.pages.errors", page="tolerances"),
            Part("manufacturing", "cases.lin.pages.manufacturing", page="tolerances"),
            Part("steering", "cases.lin.pages.steering", page="friction"),
            Part("friction", "cases.lin.pages.friction", page="friction"),
            Part("friction-screw", "cases.lin.pages.friction_screw", page="friction"),
            Part("formulations", "cases.lin.pages.formulations", page="robustness"),
        ),
        functions={
            "bench": "cases.lin.bench:bench_jobs",
            "timing": "cases.lin.bench:timing_tables",
            "stability": "cases.lin.extremes.items:table_section_items",
        },
    ),
    "of smith": Registration(parts=(Part("smith", "cases.smith.page", page="sources"),)),
    "of kalker": Registration(
        parts=(
            Part(
                "rolling",
                "cases.kalker.page",
                meshed="no motion against the static reference, sizes of bodies",
                page="rolling",
            ),
        )
    ),
    "of liu": Registration(
        parts=(Part("liu", "cases.liu.page", page="sources"),),
        functions={
            "bench": "cases.liu.bench:jobs",
            "timing jobs": "cases.liu.bench:jobs",
            "references": "cases.liu.evidence.bodies:references",
        },
    ),
    "of external": Registration(
        parts=(
            Part("external", "cases.external.page", runs=True, page="outside"),
            Part("holding", "cases.external.holding", runs=True, page="outside"),
        )
    ),
    "of makers": Registration(
        parts=(Part("outside", "cases.makers.page", page="outside"),), functions={"outside": "cases.makers.page:first_page"}
    ),
}


@cache
def registered() -> Mapping[str, Registration]:
    """Registrations by name: those of wings, sorted, then of sources in their order; without what is absent, or needs what
    is."""
    present: dict[str, Registration] = {}
    for name in sorted(path.parent.name for path in ROOT.glob("wings/*/registration.py")):
        one = import_module(f"{__package__}.wings.{name}.registration").REGISTRATION
        if all(ROOT.parent.joinpath(folder).is_dir() for folder in one.folders):
            present[name] = one
    while absent := [name for name, one in present.items() if not set(one.needs) <= present.keys()]:
        for name in absent:
            del present[name]
    return present | OF_CASES


def load(function: str) -> Any:
    """The object that ``module:name`` names, imported now."""
    module, _, name = function.partition(":")
    return getattr(import_module(f"{__package__}.{module}"), name)


def offered(hook: str) -> list[Any]:
    """The functions of a name of `HOOKS` that wings and sources offer, imported now."""
    assert hook in HOOKS, hook
    return [load(one.functions[hook]) for one in registered().values() if hook in one.functions]


def needed(hook: str, origin: str, key: str, value: str) -> Any:
    """The one function of a name of `HOOKS`. Raises InputError, said of a key and its value, where its wing is absent."""
    functions = offered(hook)
    if not functions:
        raise InputError(origin, key, value, "with the wing that does it", f"install rollbench whole: {hook} is left out")
    return functions[0]


def parts(part_of_core: Sequence[Part]) -> list[Part]:
    """Sections of the report: the core's and those that are added, without those that need an absent wing."""
    added = [part for one in registered().values() for part in one.parts]
    return [part for part in (*part_of_core, *added) if set(part.needs) <= registered().keys()]


def kinds() -> Mapping[str, str]:
    """Kinds of scenes that wings add, in their order, and where their record is."""
    return {kind: where for one in registered().values() for kind, where in one.kinds.items()}

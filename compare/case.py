"""Cases: publications whose results rollbench reproduces, with their printed numbers, scenes, computations and pages.

The cases of rollbench are the folders of ``compare/cases``, listed in `CASES`. Another package adds a case by an entry
point of the group ``rollbench.cases`` that names its `Case` record; it is imported when printed numbers are judged.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cache
from importlib import import_module, resources
from pathlib import Path
from typing import Any

from rollbench.compare.errors import InputError

#: Group of entry points by which other packages add cases.
GROUP = "rollbench.cases"


@dataclass(frozen=True)
class ReportPart:
    """Part of the validation report (one section or several): its page, and whether it needs 3D runs or gmsh."""

    #: Name for the option ``--only``.
    name: str
    #: Name of the page on which the part is shown.
    page_name: str
    #: Module in ``package`` whose function ``make_section`` makes the part; ``module:function`` for another function.
    maker: str
    #: Whether the part is included in a quick report.
    in_quick_report: bool = False
    #: Whether the part shows results of runs of the 3D reference.
    shows_3d_runs: bool = False
    #: Whether the part shows measured run times.
    shows_run_times: bool = False
    #: Whether the whole part needs gmsh.
    needs_gmsh: bool = False
    #: Description of the contents that need gmsh, if the rest of the part does not; empty: none.
    contents_needing_gmsh: str = ""
    #: Package in which the module of ``maker`` is looked up.
    package: str = "rollbench.compare"

    @property
    def maker_module(self) -> str:
        """Name of the module that makes the part."""
        return f"{self.package}.{self.maker.partition(':')[0]}"

    @property
    def cases(self) -> list[Case]:
        """Cases that the part may use: the one to which it belongs, or else all."""
        return [case for case in all_cases() if case.package == self.package] or list(all_cases())


@dataclass(frozen=True)
class Case:
    """A publication, or several similar ones, whose printed numbers and claims are compared with computed values.

    The folder of its Python package contains ``printed/NAME-*.toml`` (numbers and claims with their expected verdicts),
    ``scenes/*.toml``, ``computations.toml`` (how each number is computed) and ``misprints.toml``. What else it brings is
    named here as ``module:name`` in its package.
    """

    #: Short name of the publication, such as "lin"; names of its printed tables begin with it and a hyphen ("lin-3.5").
    name: str
    #: Title of the publication in reports and on the terminal; empty if no printed numbers of it are compared.
    title: str
    #: Import name of the Python package in the case's folder.
    package: str
    #: Module of ``package`` whose ``make_section(study, step)`` returns the sections of the case's page in the report;
    #: empty for a case without page, or with ``parts``.
    page: str = ""
    #: Parts of the case's page in the report, if ``page`` does not make it.
    parts: tuple[ReportPart, ...] = ()
    #: Whether the first of two processes that make the report makes this page.
    in_first_process: bool = False
    #: Models (`compare.models.model.Model`) with which the publication computes.
    models: str = ""
    #: Kinds of scenes for which only friction is computed (`compare.scenes.kinds.FrictionSceneKind`), by name.
    scene_kinds: str = ""
    #: Functions that compute the friction of a scene of these kinds, by name of the kind.
    friction: str = ""
    #: How scenes of these kinds are solved as rolling balls (`compare.studies.rolling.cases.RollingOfKind`), by name of the
    #: kind.
    rolling: str = ""
    #: Function ``(cache, max_error)`` that returns checks of the gate.
    checks: str = ""
    #: Functions that solve a hard-to-solve scene, by name of the formulation of the equations, for the table of stability.
    formulations: str = ""
    #: Function that returns texts and tables of the report's section on stability.
    stability: str = ""
    #: Function ``(fresh)`` that yields scenes, with mesh levels, that a report must solve in 3D beforehand.
    references: str = ""
    #: Function ``(cache)`` that returns rows of errors against published values, by quantity, for the first page.
    published_errors: str = ""
    #: Function ``(cache)`` that returns functions that measure run times, by what they time (`compare.studies.run_times`).
    time_jobs: str = ""

    @property
    def report_parts(self) -> tuple[ReportPart, ...]:
        """Parts of the report that the case makes."""
        whole = (ReportPart(self.name, self.name, self.page),) if self.page else ()
        return tuple(replace(part, package=self.package) for part in self.parts or whole)

    @property
    def folder(self) -> Path:
        """Folder that contains the case's printed tables, scenes and ``computations.toml``."""
        return Path(str(resources.files(self.package)))

    def files(self, folder: str) -> dict[str, Path]:
        """Return the case's TOML files in its subfolder ``printed`` or ``scenes``, by file name without suffix."""
        return {path.stem: path for path in sorted(self.folder.joinpath(folder).rglob("*.toml"))}

    @property
    def modules(self) -> list[str]:
        """Names of all modules of the case's package."""
        paths = (path.relative_to(self.folder).with_suffix("") for path in sorted(self.folder.rglob("*.py")))
        return [".".join((self.package, *path.parts)).removesuffix(".__init__") for path in paths]

    def module_of(self, function: str) -> str:
        """Return the name of the module with a function or other object of the case; ``function``: as ``module:name``."""
        return f"{self.package}.{function.partition(':')[0]}"

    def import_object(self, function: str) -> Any:
        """Import and return a function or other object of the case's package; ``function``: its name ``module:name``."""
        return getattr(import_module(self.module_of(function)), function.partition(":")[2])


#: Cases of rollbench, in the order of the report.
CASES = (
    Case(
        "lin",
        "Lin (2019)",
        "rollbench.compare.cases.lin",
        parts=(
            ReportPart("lin", "lin", "pages.tables", shows_run_times=True),
            ReportPart("cases", "lin", "pages.chapter_2:cases_section", in_quick_report=True, shows_3d_runs=True),
            ReportPart("reconstruction", "lin", "pages.reconstruction", shows_3d_runs=True),
            ReportPart("hertz", "lin", "pages.chapter_2:hertz_section"),
            ReportPart("formulations", "lin", "pages.chapter_2:formulations_section"),
            ReportPart("errors", "lin", "pages.chapter_2:errors_section"),
            ReportPart("manufacturing", "lin", "pages.chapter_2:manufacturing_section"),
            ReportPart("friction", "lin", "pages.friction"),
            ReportPart("steering", "lin", "pages.steering"),
            ReportPart("friction-screw", "lin", "pages.friction:screw_section"),
        ),
        in_first_process=True,
        models="models:MODELS",
        scene_kinds="kinds.table:KINDS",
        friction="kinds.friction:SOLVERS",
        rolling="kinds.rolling:ROLLING",
        checks="newton:check_against_energy_solver",
        formulations="newton:FORMULATIONS",
        time_jobs="times:time_jobs",
        stability="extremes:extreme_cases_text_and_table",
    ),
    Case("smith", "Smith (1994)", "rollbench.compare.cases.smith", "page", in_first_process=True),
    Case(
        "kalker",
        "Kalker (1990)",
        "rollbench.compare.cases.kalker",
        parts=(
            ReportPart(
                "rolling", "kalker", "page", contents_needing_gmsh="no motion against the static reference, sizes of bodies"
            ),
        ),
    ),
    Case(
        "liu",
        "Liu et al. (2025)",
        "rollbench.compare.cases.liu",
        "page",
        in_first_process=True,
        models="models:MODELS",
        references="page:scenes_and_levels_to_solve_again_in_3d",
    ),
    Case(
        "external",
        "other programs, makers, textbooks",
        "rollbench.compare.cases.external",
        parts=(
            ReportPart("external", "external", "page", shows_3d_runs=True),
            ReportPart("holding", "external", "page:fixation_section", shows_3d_runs=True),
        ),
    ),
    Case(
        "makers",
        "",
        "rollbench.compare.cases.makers",
        parts=(ReportPart("outside", "makers", "page"),),
        published_errors="page:first_page",
    ),
)


@cache
def cases_of_other_packages() -> tuple[Case, ...]:
    """Return the cases (publications to reproduce) that other installed packages add by entry points, sorted by name.

    InputError if an entry point cannot be imported, is no `Case`, or has the name of another case.
    """
    from importlib.metadata import entry_points  # slow to import, so only where it is needed

    found: dict[str, Case] = {}
    for point in sorted(entry_points(group=GROUP), key=lambda point: point.name):
        place = f"entry point {point.name}"
        allowed = "an object of the class rollbench.compare.case.Case, in a package that can be imported"
        advice = "correct the package that adds this entry point, or uninstall it"
        try:
            one = point.load()
            folder = one.folder if isinstance(one, Case) else None
        except Exception as error:
            raise InputError(place, point.value, f"{type(error).__name__}: {error}", allowed, advice) from error
        if folder is None:
            raise InputError(place, point.value, repr(one), allowed, advice)
        if one.name in found or one.name in (case.name for case in CASES):
            raise InputError(place, "name", f'"{one.name}"', "a name that no other case has", advice)
        found[one.name] = one
    return tuple(found.values())


def all_cases() -> tuple[Case, ...]:
    """Return all cases (publications to reproduce): those of rollbench, then those that other installed packages add."""
    return (*CASES, *cases_of_other_packages())


def modules_for_all_scenes() -> list[str]:
    """Return the names of the modules with models and kinds of scenes of all cases, which are imported by these names."""
    brought = ((case, (case.models, case.scene_kinds, case.friction, case.rolling)) for case in all_cases())
    return [case.module_of(name) for case, names in brought for name in names if name]


@cache
def brought_by_cases(field: str) -> dict[str, Any]:
    """Return what all cases bring in the field ``field`` of `Case`, such as "scene_kinds": one dictionary of theirs all."""
    brought = [case.import_object(path) for case in all_cases() if (path := getattr(case, field))]
    return {name: value for of_case in brought for name, value in of_case.items()}


@cache
def shipped_toml_files(folder: str) -> dict[str, Path]:
    """Return all TOML files of scenes or printed tables that are included with rollbench, by file name without suffix.

    ``folder``: "scenes" or "printed".
    """
    root = Path(__file__).parent
    files = (path for of in (folder, f"cases/*/{folder}/**") for path in root.glob(f"{of}/*.toml"))
    return {path.stem: path for path in sorted(files, key=lambda path: path.stem)}


def find_file_of_other_packages(folder: str, name: str) -> Path | None:
    """Return the file of the scene or printed table called ``name`` from a case of another package; None without one.

    ``folder``: "scenes" or "printed".
    """
    return next((files[name] for case in cases_of_other_packages() if name in (files := case.files(folder))), None)


def case_files_named(name: str, cases: Iterable[Case] = CASES) -> dict[Case, Path]:
    """Return the path of the file ``name``, such as ``misprints.toml``, for each of ``cases`` whose folder has it."""
    return {case: path for case in cases if (path := case.folder / name).is_file()}

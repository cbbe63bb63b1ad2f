"""Tables of the manual that define the numbers in the JSON output; the definitions are stated at the records' fields."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from typing import NamedTuple

from rollbench.meshes.quantity import QuantityDescription, quantity_descriptions


class DefinitionTable(NamedTuple):
    """A table of the manual that defines a group of output numbers."""

    #: Title of the table.
    title: str
    #: Text above the table.
    about: str
    #: For each part of the table, the beginning of the JSON paths of its numbers, and the record class whose fields are
    #: these numbers, as "module:class" of this package; results ask this table, which imports them only when asked.
    records: tuple[tuple[str, str], ...]

    def paths(self) -> Iterator[tuple[str, QuantityDescription]]:
        """Yield, for each number in this table, the end of its JSON path, such as ``loads.max_N``, and its definition."""
        for where, name in self.records:
            module, _, kind = name.partition(":")
            for _, one in quantity_descriptions(getattr(import_module(f"rollbench.{module}"), kind)):
                if one.definition:
                    yield f"{where}{one.key.removeprefix('torque.')}{one.parts}", one  # torques are in other groups, too


#: Tables of the manual. A number is defined by the first table with a matching path: ``loads.max_N`` matches
#: summary.loads.max_N, sets[].summary.loads.max_N and answers.*.loads.max_N. FLANK is SL, SR, NL or NR; * is any one key.
TABLES = (
    DefinitionTable(
        "Loads",
        "Contact loads are normal forces between a ball and one groove flank. `compare` measures their error, and "
        "`expected_error_percent` estimates it, in per cent of the mean load.",
        (
            ("balls[].", "compare.models.set_results:BallResult"),
            ("loads.", "compare.models.set_results:BallLoadSummary"),
            ("loads.", "compare.models.set_results:RollerLoadSummary"),
            ("rollers[].", "compare.models.set_results:RollerResult"),
            ("sides.FLANK.", "compare.models.set_results:FlankLoadSummary"),
        ),
    ),
    DefinitionTable(
        "Displacement and rigidity",
        "At two points, each with its own names. `nut`: of the nut or bearing between its two parts, without shaft, "
        "supports and wind-up, to compare with a catalogue. `load_point`: of the point on which the load acts, to ground, "
        "all of it in.",
        (
            ("nut.", "compare.models.stiffness:NutStiffness"),
            ("load_point.", "compare.models.stiffness:ShaftPointStiffness"),
            ("axial.", "compare.results.solved:AxialResults"),
            ("load_path.", "compare.models.loading:LoadPath"),
            ("load_path.supports[].", "compare.models.loading:SupportShare"),
            ("", "lowfi.rating.rigidity:AxialRigidities"),
            ("stiffness.", "lowfi.statics.tangent:TangentStiffness"),
            ("centreline[].", "compare.results.solved:AxisPointDisplacement"),
        ),
    ),
    DefinitionTable(
        "Load curve",
        "Output of `solve --curve`, in which a range of loads replaces the scene's loads.",
        (("", "compare.results.load_curve:LoadCurve"), ("points[].", "compare.results.load_curve:CurvePoint")),
    ),
    DefinitionTable(
        "Table over parameters",
        "Output of `table`; each row also has the values of the varied parameters, with their units.",
        (("rows[].", "compare.results.table:TableRow"),),
    ),
    DefinitionTable(
        "Scenes side by side",
        "Output of `solve A B`, in the order of the scenes.",
        (("scenes[].", "compare.results.side_by_side:Alternative"), ("", "compare.results.side_by_side:SideBySide")),
    ),
    DefinitionTable(
        "Contact, ellipse and static safety",
        "For the contact with the highest pressure, from its load and curvatures by Hertz's theory: an elliptical contact "
        "of a ball, a rectangular contact of a roller.",
        (
            ("worst_contact.", "lowfi.rating.contacts:BallContact"),
            ("worst_contact.", "lowfi.rating.contacts:RollerContact"),
            ("rib_contact.", "lowfi.bearings.tapered_roller:RibContact"),
            ("clearance.", "meshes.one_arc:InternalClearance"),
            ("truncation.", "lowfi.rating.contacts:EllipseTruncation"),
            ("static_safety.", "lowfi.rating.contacts:StaticSafety"),
        ),
    ),
    DefinitionTable(
        "Life, ratings and preload",
        "By ISO 281 and ISO/TS 16281 for bearings and ISO 3408-5 for screws, computed from the geometry of these parts, "
        "not taken from a catalogue; the theory is in [](../theory/rating.md).",
        (
            ("life.", "lowfi.rating.life:Life"),
            ("modified_life.", "lowfi.rating.iso_lives:ModifiedLife"),
            ("reference_life.", "lowfi.rating.iso_lives:ReferenceLife"),
            ("ratings.", "lowfi.rating.contacts:Ratings"),
            ("shaft.", "lowfi.rating.catalogue_checks:ShaftLimits"),
            ("", "compare.models.set_results:SetResult"),
            ("preload.", "compare.models.loading:Preload"),
            ("starting_torque.", "lowfi.bearings.torque:PalmgrenLoadTorque"),
            ("axis_life.", "lowfi.rating.life:SystemLife"),
            ("roller_torque.", "lowfi.bearings.torque:RollerBearingTorque"),
            ("contact_lost.", "compare.models.loading:LiftOff"),
        ),
    ),
    DefinitionTable(
        "Friction",
        "Torques act about the screw's axis. Their error is mainly that of the coefficient of friction, which is an input; "
        "`band` shows its effect.",
        (
            ("band.", "compare.results.friction:FrictionBand"),
            ("onset.", "compare.results.friction:FrictionOnset"),
            ("play.", "compare.results.friction:FrictionPlay"),
            ("bearing_torque.", "lowfi.bearings.torque:BallBearingTorque"),
            ("roller_torques[].", "lowfi.bearings.torque:RollerBearingTorque"),
            ("drive.", "compare.models.load_cases:AxisDrive"),
            ("drive.sets[].", "compare.models.load_cases:ShaftTorque"),
            ("", "compare.results.friction:Friction"),
            ("", "compare.results.friction:FrictionBall"),
            ("losses.by_contact_W[].", "compare.results.friction:FlankLosses"),
        ),
    ),
    DefinitionTable(
        "How far to trust it",
        "An error is 100 (value - reference)/|reference| (`compare/measure.py`). The error of a contact load is in per "
        "cent of the reference's mean load unless a name says otherwise.",
        (
            ("model_form.", "compare.models.model_form:ExpectedError"),
            ("", "compare.results.comparison:ModelLoads"),
            ("", "compare.results.comparison:Comparison"),
            ("uncertainty.", "compare.models.uncertainty:Uncertainty"),
            ("verdicts[].", "compare.gate.verdict:VerdictRow"),
        ),
    ),
    DefinitionTable(
        "Balance and solver",
        "",
        (("equilibrium.", "lowfi.statics.result:Equilibrium"), ("solver.", "lowfi.statics.result:SolverReport")),
    ),
    DefinitionTable(
        "Several nuts or bearings, and specimens",
        "`statistics.nut_tangent_N_per_um` and `statistics.load_point_tangent_N_per_um` are those of each specimen, as "
        "`nut.tangent_N_per_um` and `load_point.tangent_N_per_um`; of several nuts or bearings on a shaft the first is "
        "that of all nuts, or of all bearings where there is no nut.",
        (
            ("sets[].", "lowfi.statics.result:SetResult"),
            ("housings[].", "lowfi.statics.result:HousingResult"),
            ("summary.", "compare.results.solved:Result"),
            ("statistics.*.", "compare.results.data:Statistics"),
            ("", "compare.results.data:Ensemble"),
        ),
    ),
    DefinitionTable(
        "Load cases",
        "The output of a scene with `[[cases]]` has the list `cases`, each with the output of a scene with this load case "
        "only, and a summary of all cases.",
        (
            ("", "compare.scenes.duty_cycle:LoadCase"),
            ("summary.", "compare.models.load_cases:DutyCycleResults"),
            ("", "compare.models.load_cases:LivesOverDutyCycle"),
            ("standard_life.", "lowfi.rating.life:EquivalentLoadLife"),
            ("summary.", "compare.results.friction:FrictionCases"),
            ("summary[].", "compare.results.comparison:CycleSummary"),
        ),
    ),
)


@cache
def _definitions_by_path_pattern() -> tuple[tuple[re.Pattern[str], QuantityDescription], ...]:
    """Return, for every number in `TABLES` in their order, a pattern that its JSON path matches, and its definition."""
    return tuple((_json_path_pattern(path), one) for table in TABLES for path, one in table.paths())


def _json_path_pattern(path: str) -> re.Pattern[str]:
    """Return the regular expression that matches every JSON path that ends with ``path``, a path in `TABLES`."""
    named = re.escape(path).replace("FLANK", "(SL|SR|NL|NR)").replace(r"\*", r"[^.]+")
    return re.compile(rf"(.*\.)?{named}")


def definition(path: str) -> QuantityDescription | None:
    """Return the definition of a number in a command's JSON output; None if it has no definition.

    Parameters
    ----------
    path
        Keys of the number joined by dots; brackets after the key of a list may contain an index.

    Examples
    --------
    >>> definition("summary.loads.max_N").definition
    'largest contact load'
    """
    path = re.sub(r"\[\d+\]", "[]", path)
    return next((known for pattern, known in _definitions_by_path_pattern() if pattern.fullmatch(path)), None)

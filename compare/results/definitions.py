"""Tables of the manual that define the numbers in the JSON output; the definitions are stated at the records' fields."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

from rollbench.compare.gate.verdict import VerdictRow
from rollbench.compare.models import set_results
from rollbench.compare.models.load_cases import AxisDrive, DutyCycleResults, LivesOverDutyCycle, ShaftTorque
from rollbench.compare.models.loading import LiftOff, LoadPath, Preload, SupportShare
from rollbench.compare.models.model_form import ExpectedError
from rollbench.compare.models.stiffness import NutStiffness, ShaftPointStiffness
from rollbench.compare.models.uncertainty import LoadUncertainty
from rollbench.compare.results import data, solved
from rollbench.compare.results.compared import NutOrBearingComparison
from rollbench.compare.results.comparison import CycleSummary, ModelLoads, Uncertainty
from rollbench.compare.results.load_curve import CurvePoint, LoadCurve
from rollbench.compare.results.side_by_side import Alternative, SideBySide
from rollbench.compare.results.table import TableRow
from rollbench.compare.scenes.duty_cycle import LoadCase
from rollbench.lowfi.bearings.tapered_roller import RibContact
from rollbench.lowfi.bearings.torque import BallBearingTorque, PalmgrenLoadTorque, RollerBearingTorque
from rollbench.lowfi.rating.catalogue_checks import ShaftLimits
from rollbench.lowfi.rating.contacts import BallContact, EllipseTruncation, Ratings, RollerContact, StaticSafety
from rollbench.lowfi.rating.iso_lives import ModifiedLife, ReferenceLife
from rollbench.lowfi.rating.life import EquivalentLoadLife, Life, SystemLife
from rollbench.lowfi.rating.rigidity import AxialRigidities
from rollbench.lowfi.statics.result import Equilibrium, HousingResult, SetResult, SolverReport
from rollbench.meshes.one_arc import InternalClearance
from rollbench.meshes.quantity import QuantityDescription, quantity_descriptions


class DefinitionTable(NamedTuple):
    """A table of the manual that defines a group of output numbers."""

    #: Title of the table.
    title: str
    #: Text above the table.
    about: str
    #: For each part of the table, the beginning of the JSON paths of its numbers, and the record class whose fields are
    #: these numbers.
    records: tuple[tuple[str, type], ...]

    def paths(self) -> Iterator[tuple[str, QuantityDescription]]:
        """Yield, for each number in this table, the end of its JSON path, such as ``loads.max_N``, and its definition."""
        for where, kind in self.records:
            for _, one in quantity_descriptions(kind):
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
            ("balls[].", set_results.BallResult),
            ("loads.", set_results.BallLoadSummary),
            ("loads.", set_results.RollerLoadSummary),
            ("rollers[].", set_results.RollerResult),
            ("sides.FLANK.", set_results.FlankLoadSummary),
        ),
    ),
    DefinitionTable(
        "Displacement and rigidity",
        "At two points, each with its own names. `nut`: of the nut or bearing between its two parts, without shaft, "
        "supports and wind-up, to compare with a catalogue. `load_point`: of the point on which the load acts, to ground, "
        "all of it in.",
        (
            ("nut.", NutStiffness),
            ("load_point.", ShaftPointStiffness),
            ("axial.", solved.AxialResults),
            ("load_path.", LoadPath),
            ("load_path.supports[].", SupportShare),
            ("", AxialRigidities),
            ("stiffness.", solved.StiffnessAtPosition),
            ("centreline[].", solved.AxisPointDisplacement),
        ),
    ),
    DefinitionTable(
        "Load curve",
        "Output of `solve --curve`, in which a range of loads replaces the scene's loads.",
        (("", LoadCurve), ("points[].", CurvePoint)),
    ),
    DefinitionTable(
        "Table over parameters",
        "Output of `table`; each row also has the values of the varied parameters, with their units.",
        (("rows[].", TableRow),),
    ),
    DefinitionTable(
        "Scenes side by side",
        "Output of `solve A B`, in the order of the scenes.",
        (("scenes[].", Alternative), ("", SideBySide)),
    ),
    DefinitionTable(
        "Contact, ellipse and static safety",
        "For the contact with the highest pressure, from its load and curvatures by Hertz's theory: an elliptical contact "
        "of a ball, a rectangular contact of a roller.",
        (
            ("worst_contact.", BallContact),
            ("worst_contact.", RollerContact),
            ("rib_contact.", RibContact),
            ("clearance.", InternalClearance),
            ("truncation.", EllipseTruncation),
            ("static_safety.", StaticSafety),
        ),
    ),
    DefinitionTable(
        "Life, ratings and preload",
        "By ISO 281 and ISO/TS 16281 for bearings and ISO 3408-5 for screws, computed from the geometry of these parts, "
        "not taken from a catalogue; the theory is in [](../theory/rating.md).",
        (
            ("life.", Life),
            ("modified_life.", ModifiedLife),
            ("reference_life.", ReferenceLife),
            ("ratings.", Ratings),
            ("shaft.", ShaftLimits),
            ("", set_results.SetResult),
            ("preload.", Preload),
            ("starting_torque.", PalmgrenLoadTorque),
            ("axis_life.", SystemLife),
            ("roller_torque.", RollerBearingTorque),
            ("contact_lost.", LiftOff),
        ),
    ),
    DefinitionTable(
        "Friction",
        "Torques act about the screw's axis. Their error is mainly that of the coefficient of friction, which is an input; "
        "`band` shows its effect.",
        (
            ("band.", data.FrictionBand),
            ("onset.", data.FrictionOnset),
            ("play.", data.FrictionPlay),
            ("bearing_torque.", BallBearingTorque),
            ("roller_torques[].", RollerBearingTorque),
            ("drive.", AxisDrive),
            ("drive.sets[].", ShaftTorque),
            ("", data.Friction),
            ("", data.FrictionBall),
        ),
    ),
    DefinitionTable(
        "How far to trust it",
        "An error is 100 (value - reference)/|reference| (`compare/measure.py`). The error of a contact load is in per "
        "cent of the reference's mean load unless a name says otherwise.",
        (
            ("model_form.", ExpectedError),
            ("", ModelLoads),
            ("", NutOrBearingComparison),
            ("", Uncertainty),
            ("uncertainty.", LoadUncertainty),
            ("verdicts[].", VerdictRow),
        ),
    ),
    DefinitionTable("Balance and solver", "", (("equilibrium.", Equilibrium), ("solver.", SolverReport))),
    DefinitionTable(
        "Several nuts or bearings, and specimens",
        "`statistics.nut_tangent_N_per_um` and `statistics.load_point_tangent_N_per_um` are those of each specimen, as "
        "`nut.tangent_N_per_um` and `load_point.tangent_N_per_um`; of several nuts or bearings on a shaft the first is "
        "that of all nuts, or of all bearings where there is no nut.",
        (
            ("sets[].", SetResult),
            ("housings[].", HousingResult),
            ("summary.", solved.Result),
            ("statistics.*.", data.Statistics),
            ("", data.Ensemble),
        ),
    ),
    DefinitionTable(
        "Load cases",
        "The output of a scene with `[[cases]]` has the list `cases`, each with the output of a scene with this load case "
        "only, and a summary of all cases.",
        (
            ("", LoadCase),
            ("summary.", DutyCycleResults),
            ("", LivesOverDutyCycle),
            ("standard_life.", EquivalentLoadLife),
            ("summary.", data.FrictionCases),
            ("summary[].", CycleSummary),
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

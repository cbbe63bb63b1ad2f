"""Definitions of all output numbers by their path in JSON, taken from record fields; tables of the manual."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

from rollbench.compare.gate.verdict import Verdict
from rollbench.compare.models.answers import AxisAnswers, LoadAnswers
from rollbench.compare.models.drive import AxisDrive, SetDrive
from rollbench.compare.models.load_cases import CycleResults, Lives
from rollbench.compare.models.loading import LiftOff, LoadPath, LoadTaker, Preload
from rollbench.compare.models.model_form import ModelForm
from rollbench.compare.models.uncertainty import LoadUncertainty
from rollbench.compare.results import scene_json
from rollbench.compare.results.comparison import CycleSummary, ModelLoads, Uncertainty
from rollbench.compare.results.data import (
    Ensemble,
    Friction,
    FrictionBall,
    FrictionBand,
    FrictionCases,
    FrictionOnset,
    FrictionPlay,
    Statistics,
)
from rollbench.compare.results.load_curve import CurvePoint, LoadCurve
from rollbench.compare.results.side_by_side import Alternative, SideBySide
from rollbench.compare.results.solved import ExpectedError
from rollbench.compare.results.table import TableRow
from rollbench.compare.scenes.duty_cycle import LoadCase
from rollbench.lowfi.bearings.rib import RibContact
from rollbench.lowfi.bearings.roller_torque import RollerTorque
from rollbench.lowfi.bearings.torque import BallTorque, LoadTorque
from rollbench.lowfi.rating.contacts import Contact, Ratings, RollerContact, StaticSafety, Truncation
from rollbench.lowfi.rating.life import EquivalentLife, Life, SystemLife
from rollbench.lowfi.rating.modified import ModifiedLife
from rollbench.lowfi.rating.reference import ReferenceLife
from rollbench.lowfi.rating.rigidity import Rigidities
from rollbench.lowfi.rating.shaft import ShaftLimits
from rollbench.lowfi.statics.result import Equilibrium, HousingResult, SetResult, SolverReport
from rollbench.meshes.one_arc import Clearance
from rollbench.meshes.quantity import Stated, stated_in


class Table(NamedTuple):
    """A table of the manual that defines the numbers of the output."""

    #: Title.
    title: str
    #: Text above it.
    about: str
    #: Records, with their path in JSON.
    records: tuple[tuple[str, type], ...]

    def paths(self) -> Iterator[tuple[str, Stated]]:
        """Yield, for every defined number, the last part of its path in JSON and its definition."""
        for where, kind in self.records:
            for _, one in stated_in(kind):
                if one.definition:
                    yield f"{where}{one.key.removeprefix('torque.')}{one.parts}", one  # other tables have torques, too


#: The first table with a matching path gives the definition: ``loads.max_N`` stands for summary.loads.max_N,
#: sets[].summary.loads.max_N, answers.*.loads.max_N; FLANK is SL, SR, NL or NR; * is any one key.
TABLES = (
    Table(
        "Loads",
        "Contact loads are normal forces between a ball and one flank. Their error is the one that `compare` measures and "
        "`expected_error_percent` promises, in per cent of the mean load.",
        (
            ("balls[].", scene_json.BallRow),
            ("loads.", scene_json.LoadSums),
            ("loads.", scene_json.RollerSums),
            ("rollers[].", scene_json.RollerRowAnswer),
            ("sides.FLANK.", scene_json.SideSums),
        ),
    ),
    Table(
        "Displacement and rigidity",
        "",
        (
            ("axial.", scene_json.Axial),
            ("load_path.", LoadPath),
            ("load_path.supports[].", LoadTaker),
            ("", Rigidities),
            ("stiffness.", scene_json.StiffnessAt),
            ("centreline[].", scene_json.CentrelinePoint),
        ),
    ),
    Table(
        "Load curve",
        "Of `solve --curve`; the load goes from one sign to the other in place of the scene's loads.",
        (("", LoadCurve), ("points[].", CurvePoint)),
    ),
    Table(
        "Table over keys",
        "Of `table`; each row also has its place, by the keys that the table goes over and their units.",
        (("rows[].", TableRow),),
    ),
    Table(
        "Scenes side by side", "Of `solve A B`, in the order of the scenes.", (("scenes[].", Alternative), ("", SideBySide))
    ),
    Table(
        "Contact, ellipse and static safety",
        "Of the contact of the highest pressure, by Hertz' theory of its load and curvatures: an ellipse of a ball, a "
        "strip of a roller.",
        (
            ("worst_contact.", Contact),
            ("worst_contact.", RollerContact),
            ("rib_contact.", RibContact),
            ("clearance.", Clearance),
            ("truncation.", Truncation),
            ("static_safety.", StaticSafety),
        ),
    ),
    Table(
        "Life, ratings and preload",
        "ISO 281 and ISO/TS 16281 for bearings, ISO 3408-5 for screws, as computed of these parts and not a maker's; the "
        "theory is in [](../theory/rating.md).",
        (
            ("life.", Life),
            ("modified_life.", ModifiedLife),
            ("reference_life.", ReferenceLife),
            ("ratings.", Ratings),
            ("shaft.", ShaftLimits),
            ("", LoadAnswers),
            ("preload.", Preload),
            ("starting_torque.", LoadTorque),
            ("axis_life.", SystemLife),
            ("roller_torque.", RollerTorque),
            ("contact_lost.", LiftOff),
        ),
    ),
    Table(
        "Friction",
        "Torques act about the screw's axis. Their error is dominated by the coefficient of friction, which is an input: "
        "see `band`.",
        (
            ("band.", FrictionBand),
            ("onset.", FrictionOnset),
            ("play.", FrictionPlay),
            ("bearing_torque.", BallTorque),
            ("drive.", AxisDrive),
            ("drive.sets[].", SetDrive),
            ("", Friction),
            ("", FrictionBall),
        ),
    ),
    Table(
        "How far to trust it",
        "Error is defined once, in `compare/measure.py`: 100 (value - reference)/|reference|; of loads in per cent of the "
        "reference's mean load unless a name says otherwise.",
        (
            ("model_form.", ModelForm),
            ("", ModelLoads),
            ("", ExpectedError),
            ("", Uncertainty),
            ("uncertainty.", LoadUncertainty),
            ("verdicts[].", Verdict),
        ),
    ),
    Table("Balance and solver", "", (("equilibrium.", Equilibrium), ("solver.", SolverReport))),
    Table(
        "Several sets, and members",
        "Of members of one set, `statistics.load_stiffness_N_per_um` is the tangent stiffness where the loads act, of "
        "shaft and nut together: 0.1 % more load over how far its points move along it. `axial.tangent_N_per_um` is that "
        "at the nut's centre.",
        (
            ("sets[].", SetResult),
            ("housings[].", HousingResult),
            ("summary.", AxisAnswers),
            ("statistics.*.", Statistics),
            ("", Ensemble),
        ),
    ),
    Table(
        "Load cases",
        "A scene with `[[cases]]` has the list `cases`, each entry as the scene alone would have it, and what they say "
        "together.",
        (
            ("", LoadCase),
            ("summary.", CycleResults),
            ("", Lives),
            ("standard_life.", EquivalentLife),
            ("summary.", FrictionCases),
            ("summary[].", CycleSummary),
        ),
    ),
)


@cache
def _known_definitions() -> tuple[tuple[re.Pattern[str], Stated], ...]:
    """Return pattern and definition of every path in `TABLES`, in their order."""
    return tuple((_path_pattern(path), one) for table in TABLES for path, one in table.paths())


def _path_pattern(path: str) -> re.Pattern[str]:
    """Return the pattern of full JSON paths that end with a path of `TABLES`."""
    named = re.escape(path).replace("FLANK", "(SL|SR|NL|NR)").replace(r"\*", r"[^.]+")
    return re.compile(rf"(.*\.)?{named}")


def definition(path: str) -> Stated | None:
    """Return the definition of the number at a path in a command's JSON; None if it has none.

    Parameters
    ----------
    path
        Keys joined by dots; indices of lists may be in the brackets.

    Examples
    --------
    >>> definition("summary.loads.max_N").definition
    'largest contact load'
    """
    path = re.sub(r"\[\d+\]", "[]", path)
    return next((known for pattern, known in _known_definitions() if pattern.fullmatch(path)), None)

"""Records say a thing once: no two share half of their fields."""

import ast
from itertools import combinations
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[3]
PACKAGES = ("lowfi", "hifi", "meshes", "compare", "reports")
#: Smallest number of shared fields that counts; fewer are names such as `name` and `title`.
FEWEST = 3

#: Pairs of records that share half of their fields, and why both stand.
EXPLAINED = {
    ("BallResult", "RollerResult"): "a ball has four flanks with an angle each, a roller two races and a line load",
    ("NutStiffness", "LoadPointStiffness"): "the same quantities at two places, with a definition and an error each",
    ("ShaftSection", "BeamSection"): "the 3D reference shares no formula with the models that it judges",
    ("CoarseBallMesh", "CoarseGroovedBodyMesh"): "meshes of two bodies: only a groove's facets deviate from its flank",
    ("GeometryWithErrors", "GeometriesWithErrors"): "one specimen, and arrays of many specimens without derivatives",
    ("ForceState", "Step"): "a state of the iteration, and a change of it without energy",
    ("Contacts", "NormalForces"): "elements of statics have a tangential stiffness, Hertz's law of one contact a distance",
    ("LoadedBalls", "BodyMotionProblem"): "the equations as the source prints them, and those of least dissipation",
    ("FrictionCase", "BallsUnderLoad"): "what a user asks for with its static result, and the contacts that follow from it",
    ("BallsUnderLoad", "SceneInMotion"): "balls at known contact loads, and a screw over time, whose loads follow",
    ("ContactDissipationRatio", "DissipationState"): "one contact, and the sum over a body with its balance",
    ("ComputedBand", "DescriptorWithRange"): "a maker's value with its band, and a feature of a scene with those compared",
    ("BallScrewFrictionKeys", "BearingBallKeys"): "tables of files of two kinds of scene, each with its own ranges",
    ("BallScrewFrictionKeys", "LinearBearingKeys"): "tables of files of two kinds of scene, each with its own ranges",
    ("BearingBallKeys", "BearingPairKeys"): "tables of files of two kinds of scene, each with its own ranges",
    ("FrictionLawKeys", "BearingBallScene"): "the table of the file in its units, and the scene that its kind solves",
    ("SolvedScene", "SolutionsByLoad"): "one solved scene of a sweep, and solutions of one scene under many loads",
    ("LoadedScrew", "Sketch"): "a 3D picture and a drawing of the same scene",
    ("Picture", "Sketch"): "a picture that is drawn already, and the scene that a drawing shows",
    ("Section", "Page"): "a page has sections where a section has items",
}


class Fields(NamedTuple):
    """Fields of a record class, as they stand in its body."""

    name: str
    own: frozenset[str]


def is_record(node: ast.ClassDef) -> bool:
    """Whether a class is a dataclass, a named tuple or a table of a file."""
    marks = [ast.unparse(mark).partition("(")[0] for mark in node.decorator_list]
    bases = [ast.unparse(base) for base in node.bases]
    return bool({"dataclass", "result_record"} & set(marks)) or any(b == "NamedTuple" or "Keys" in b for b in bases)


def records() -> list[Fields]:
    """Every record class with at least `FEWEST` fields of its own."""
    out = []
    for path in (path for package in PACKAGES for path in sorted((ROOT / package).rglob("*.py"))):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ClassDef) and is_record(node):
                said = (x for x in node.body if isinstance(x, ast.AnnAssign) and isinstance(x.target, ast.Name))
                named = (ast.unparse(x.target) for x in said if "ClassVar" not in ast.unparse(x.annotation))
                out.append(Fields(node.name, frozenset(named) - {"_"}))
    return [one for one in out if len(one.own) >= FEWEST]


@pytest.mark.slow
def test_no_two_records_share_half_of_their_fields_but_those_that_are_explained() -> None:
    shared = {
        frozenset((a.name, b.name))
        for a, b in combinations(records(), 2)
        if len(a.own & b.own) >= FEWEST and 2 * len(a.own & b.own) >= len(a.own | b.own)
    }
    explained = set(map(frozenset, EXPLAINED))
    assert not [sorted(pair) for pair in shared - explained], "say it once, or explain it"
    assert not [sorted(pair) for pair in explained - shared], "no longer so: delete the line"

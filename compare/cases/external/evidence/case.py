"""Inputs of the external cases that no scene describes, in SI, and what was assumed to run them."""

from __future__ import annotations

from typing import Any

from rollbench.compare import data
from rollbench.compare.models.registry import run_model
from rollbench.compare.models.study import Study
from rollbench.compare.scenes import catalogue
from rollbench.lowfi.statics.result import AxisResult, SetResult
from rollbench.meshes.axis import Assembly
from rollbench.meshes.units import parse

#: Beginning of the names of tables and scenes of this kind.
PREFIX = "external-"


def inputs() -> dict[str, Any]:
    """The tables of ``cases.toml`` as they stand, quantities as texts."""
    return data.table("cases/external/cases.toml")


def given(case: str, key: str, quantity: str) -> float:
    """An input of a case in SI. Raises KeyError for one that is not there."""
    return parse(inputs()[case][key], quantity)


def assumptions() -> dict[str, tuple[str, ...]]:
    """What was inferred or chosen to run each case without a scene of its own, by case."""
    return {name: tuple(table["assumed"]) for name, table in inputs().items() if "assumed" in table}


def assembly(name: str) -> Assembly:
    """A shipped scene ``external-NAME`` with sets on a shaft. Raises AssertionError where it is another kind."""
    found = catalogue.shipped(PREFIX + name)
    if not isinstance(found, Assembly):
        raise AssertionError(f"{PREFIX}{name} has sets on a shaft")
    return found


def solved(study: Study, name: str) -> tuple[AxisResult, SetResult]:
    """Result of a shipped scene ``external-NAME`` with one rolling set between rigid rings, and that of its set."""
    result = study.once(_solved, name)
    return result, result.sets[0]


def _solved(study: Study, name: str) -> AxisResult:  # noqa: ARG001 - kept by the study
    result = run_model(assembly(name), "lin")
    if not result.converged:
        raise AssertionError(f"{PREFIX}{name}: {result.status}")
    return result

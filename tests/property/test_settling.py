"""Preloaded screws whose loads once did not settle, or were far from the refined model's: each has a 3D answer.

A round solves the places of the balls with the loads and takes a contact's place along its track from the motions of ball
and groove, so that the next finds no more than the turn of the normals: three or four updates settle them all. With places
at the middles of the pressures of the round before, the one named 32x5 takes twelve.
"""

from pathlib import Path

import pytest
from tests.shipped_texts import parse_file

from rollbench.compare.measure import load_error
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.compare.reference.computing import compute_reference_runs
from rollbench.compare.reference.store import measuring_conditions
from rollbench.compare.reference.tasks import ReferenceTask
from rollbench.hifi import reference
from rollbench.lowfi.statics.nominal import count_nominal_contacts

SCENES = Path(__file__).with_name("settling")
CASES = [("end-displaced-and-turned", 1), ("end-displaced-and-turned", 2)]
CASES += [(name, 1) for name in ("16x5-preloaded", "25x5-preloaded", "25x10-misaligned", "32x5-end-displaced")]
#: The one of the fewest contacts.
SMALL = CASES[0]


MARKED = [pytest.param(*case, marks=[] if case == SMALL else [pytest.mark.survey]) for case in CASES]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "level"), MARKED)
def test_loads_settle_in_few_rounds_and_the_refined_model_is_near(name, level, monkeypatch):
    solve, updates = reference.solve_reference, []

    def counted(*given, **named):
        found = solve(*given, **named)
        updates.append(found.normal_update_count)
        return found

    monkeypatch.setattr(reference, "solve_reference", counted)
    scene = parse_file(SCENES / f"{name}.toml")
    (run,) = compute_reference_runs(ReferenceTask((scene,), level))
    assert (run.status, run.moving, run.measured) == ("converged", 0.0, measuring_conditions())
    assert max(updates) <= 4
    low = run_model(scene, "refined", ModelOptions(estimate_beam_mesh_error=False))
    error = load_error(low.load, run.load, count_nominal_contacts(scene))
    assert error.max_percent < 1.5, error
    assert error.rms_percent < 0.5, error

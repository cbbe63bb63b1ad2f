"""Results of another program: read as it printed them, extrapolated, kept, and shown beside the 3D reference."""

import json
from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare import errors
from rollbench.compare.studies.crosscheck import results, study
from rollbench.compare.studies.crosscheck.deck import DeckOptions

DAT = """
 displacements (vx,vy,vz) for set BALL1_WEAK and time  0.1000000E+01

     15095  1.828532E-03  8.032547E-04  2.913913E-03
 statistics for slave set BALL1_SL, master set SCREW_SL_1 and time  0.1000000E+01
   total surface force (fx,fy,fz) and moment about the origin (mx,my,mz)
    3.000000E+02 -2.012520E-05  4.000000E+02  2.824355E-01 -4.765494E+03 -2.947064E-01
   area,  normal force (+ = tension) and shear force (size)
    2.115257E-01 -5.167413E+02  2.813703E+00
"""
CVG = """  STEP   INC  ATT   ITER     CONT.   RESID.        CORR.      RESID.      CORR.
     1     1     1     1    70768  0.2964E+06  0.1000E+03  0.0000E+00  0.0000E+00
     1     1     1     2    20299  0.0000E+00  0.1133E-02  0.0000E+00  0.0000E+00
"""
#: Limit, what elements add to it at e = 1 and the contact law at 2e17 Pa/m, order and length of the elements' error.
LIMIT = np.array([[500.0, 0.0, 0.0, 480.0], [250.0, 40.0, 41.0, 260.0]])
MESH, SOFT, ORDER, LENGTH = 0.05 * LIMIT + 1.0 * (LIMIT > 0.0), -0.004 * LIMIT, 3.0, results.LENGTHS[10]


def element_error(b_over_h: float, growth: float):
    """Relative error of the elements at contacts of one semi-axis."""
    return results.relative_element_error(np.array(1.0 / (b_over_h * LENGTH)), np.array(growth), ORDER)


def a_run(b_over_h: float, growth: float, stiffness: float = 2e17, **changes) -> results.CalculixRun:
    """A run of loads that obey the law of the fit, with contacts of one semi-axis."""
    found = LIMIT + MESH * element_error(b_over_h, growth) + SOFT * (2e17 / stiffness)
    nodes = int(1000 * b_over_h / growth)
    meshes = (results.BodyMesh("SCREW", nodes, 40, 0.2), results.BodyMesh("NUT", 200, 80, 0.1))
    choices = {"b_over_h": b_over_h, "growth": growth, "stiffness": stiffness, "fine": 1e-4, "deck": "0" * 16}
    answer = {"meshes": meshes, "load": found, "weak": 0.005, "unbalanced": 1e-4, "iterations": 12, "correction": 1e-3}
    effort = {"seconds": 60.0, "date": "2026-01-01", "program": "CalculiX 2.20"}
    return results.CalculixRun(**(choices | answer | effort | changes))


RUNS = tuple(a_run(*mesh) for mesh in ((0.8, 0.6), (1.1, 0.6), (1.5, 0.6), (1.1, 0.8), (1.1, 0.4), (1.1, 0.6, 1e18)))
RUNS += (a_run(1.5, 0.6, nlgeom=True, load=2.0 * LIMIT),)
DATA = results.CalculixRunsOfScene("two-balls", "k", "0", "4", RUNS)


def test_what_calculix_prints_is_read_and_a_deck_known_by_what_it_says():
    forces, moved = study.read_forces_and_displacements(DAT)
    assert forces == {"BALL1_SL": (300.0, -2.01252e-5, 400.0)}
    assert moved == {"BALL1_WEAK": {15095: (1.828532e-3, 8.032547e-4, 2.913913e-3)}}
    assert study.read_iterations_and_correction(CVG) == (2, 1.133e-3)
    alike = "*NODE\n1, 2\n", "** remark\n*NODE\n1, 2", "*CONTROLS, X\n4, 8\n*NODE\n1, 2\n"
    assert len({study.deck_digest(text) for text in alike}) == 1
    assert study.deck_digest(alike[0]) != study.deck_digest("*NODE\n1, 3\n")


def test_loads_that_obey_the_law_are_extrapolated_exactly():
    """Equal loads on all contacts, so that all have one semi-axis."""
    found = results.extrapolate_calculix_loads([replace(r, load=np.where(r.load > 0.0, r.load[0, 0], 0.0)) for r in RUNS])
    assert (found.error_order, found.field_length) == (ORDER, LENGTH)
    np.testing.assert_allclose(found.load, 500.0 * (LIMIT > 0.0), atol=1e-6)
    finest = min(element_error(r.b_over_h, r.growth) for r in RUNS)
    np.testing.assert_allclose(found.uncertainty, 0.1 * 26.0 * finest * (LIMIT > 0.0), atol=1e-5)
    assert (found.element_size_effect[0, 0], found.contact_stiffness_effect[0, 0]) == pytest.approx((26.0 * finest, -2.0))
    assert found.unvaried_options == ()


def test_the_error_of_elements_is_that_of_its_derivation():
    """The relative size, to a power, over the energy of a field that falls like 1 / (c + d)."""
    h, g, p, c = 0.3, 0.5, 3.0, 0.4
    d = np.concatenate([[0.0], np.geomspace(1e-5, 1e6, 400_000)])
    energy = c / (c + d) ** 2
    assert np.trapezoid(energy, d) == pytest.approx(1.0, rel=1e-4)
    found = np.trapezoid(((h + g * d) / (c + d)) ** p * energy, d)
    assert results.relative_element_error(np.array(h / c), np.array(g), p) == pytest.approx(found, rel=1e-4)


FAMILY = ((0.6, 0.8), (0.8, 0.6), (1.2, 0.4), (1.6, 0.3))


def manufactured(noise: float) -> tuple[np.ndarray, list[results.CalculixRun]]:
    """Limits of 64 contacts and runs of another law than the fit's: an error of order 3 at the contacts, one of order 4 of
    the growth and their product, in shares of every contact's own; meshes of one size differ by ``noise`` of their e."""
    rng = np.random.default_rng(7)
    limit = rng.uniform(40.0, 500.0, (16, 4))
    share, size = rng.uniform(0.0, 1.0, (16, 4)), np.cbrt(limit / limit.mean())
    runs = []
    for b_over_h, growth in FAMILY:
        h = 1.0 / (2.0 * b_over_h * size)
        e = 0.15 * share * h**3 + 0.4 * (1.0 - share) * growth**4 + 0.1 * h**2 * growth**2
        load = limit * (1.0 + 0.6 * e * (1.0 + noise * rng.normal(size=limit.shape)))
        laws = (2e17, 1e18) if growth == 0.6 else (2e17,)
        runs += [a_run(b_over_h, growth, k, load=load * (1.0 - 4e14 / k)) for k in laws]
    return limit, runs


def test_the_uncertainty_covers_what_the_law_leaves_out_and_shows_scatter():
    extrapolated = []
    for noise, most in ((0.02, 2.5), (0.1, 5.0)):
        limit, runs = manufactured(noise)
        found = results.extrapolate_calculix_loads(runs)
        off, finest = np.abs(found.load - limit), np.abs(runs[-1].load - limit)
        assert np.mean(off <= found.uncertainty) >= 0.95
        assert off.mean() < 0.8 * finest.mean()
        assert found.uncertainty.mean() < most * finest.mean()
        # the law's share was measured on a mesh whose loads are up to 14 % larger
        np.testing.assert_allclose(found.contact_stiffness_effect, -0.002 * limit, rtol=0.15)
        extrapolated.append(found)
    quiet, loud = extrapolated
    assert loud.misfit > 2.0 * quiet.misfit
    assert loud.uncertainty.mean() > 1.5 * quiet.uncertainty.mean()


def test_too_few_runs_are_refused_and_what_is_not_varied_is_named_and_two_meshes_give_a_range():
    for kept, why in ((RUNS[1:2] + RUNS[5:6], "one mesh only"), ((RUNS[0], RUNS[5]), "in the contact stiffness alone")):
        with pytest.raises(ValueError, match=why):
            results.extrapolate_calculix_loads(kept)
    found = results.extrapolate_calculix_loads(RUNS[:2])
    assert found.unvaried_options == ("growth", "contact stiffness")
    assert not found.contact_stiffness_effect.any()
    two = [r.load for r in RUNS[:2]]
    assert found.uncertainty[0, 0] > abs(two[1] - two[0])[0, 0]  # any order and length fits


def test_results_are_kept_with_all_that_identifies_them(tmp_path):
    results.save_calculix_results(tmp_path, DATA)
    again = results.load_calculix_results(tmp_path, "two-balls")
    for one, two in zip(again.runs, RUNS, strict=True):
        np.testing.assert_allclose(one.load, two.load, rtol=1e-6)
        assert replace(one, load=0) == replace(two, load=0)
    assert (again.key, again.gmsh, again.runs[0].nodes) == ("k", "4", 1533)
    assert results.load_calculix_results(tmp_path, "other") is None
    file = results.path_of_calculix_results(tmp_path, "two-balls")
    plain = json.loads(file.read_text())
    for broken in ({**plain, "more": 1}, [], {**plain, "runs": [{**plain["runs"][0], "load": [1.0]}]}):
        file.write_text(json.dumps(broken))
        with pytest.raises(errors.InputError, match="results that rollbench crosscheck wrote"):
            results.load_calculix_results(tmp_path, "two-balls")


@pytest.mark.parametrize("name", study.STUDIES)
def test_stored_results_are_those_of_the_shipped_scenes(name):
    data = results.load_calculix_results(results.shipped_calculix_results_folder(), name)
    assert data.key == study.digest_of_shipped_scene(name)
    assert [study.deck_folder_name(o) for o in study.STUDIES[name]] == [study.deck_folder_name(r) for r in data.runs]
    for run in data.runs:
        assert run.correction < 1.0  # of its last increment; the fine halves took a second, small one
        assert run.weak < 2e-4 * run.load.max()
        assert run.unbalanced < 1e-3 * run.load.max()
    limit = results.extrapolate_calculix_loads(data.runs)
    assert np.all(limit.uncertainty >= 0.0)
    np.testing.assert_allclose(limit.load, data.runs[-1].load, atol=0.1 * limit.load.max())


def test_a_study_runs_every_deck(tmp_path, monkeypatch):
    def solved(text: str, _):
        names = [x.split("SLAVE=")[1].split(",")[0] for x in text.splitlines() if x.startswith("*CONTACT PRINT")]
        forces = {"SL": (3.0, 0.0, 4.0), "NR": (-3.0, 0.0, -4.0), "SR": (1.0, 0.0, 0.0), "NL": (-1.0, 0.0, 0.001)}
        moved = {f"BALL{i}_WEAK": {7: (0.0, 0.0, 0.001)} for i in (1, 2)}
        return study.CalculixResult({n: forces[n.split("_")[1]] for n in names}, moved, 5, 0.01, 1.0, "2026-01-01", "2.20")

    monkeypatch.setattr(study, "solve_deck_or_read_result", solved)
    decks = [DeckOptions(0.7, 0.8, half=half) for half in (False, True)]
    monkeypatch.setitem(study.STUDIES, "two-balls", decks)
    runs = study.solve_decks_of_scene(study.scene_compared_with_calculix("two-balls"), tmp_path, print).runs
    for run, deck, times in zip(runs, decks, (1.0, 2.0), strict=True):  # a half and its mirror image
        np.testing.assert_allclose(run.load, [[5.0 * times, times, times, 5.0 * times]] * 2, rtol=1e-6)
        assert (run.half, run.weak) == (deck.half, pytest.approx(0.001 * times))
        assert [m.name for m in run.meshes] == ["SCREW", "NUT", "BALL1", "BALL2"]
    assert runs[0].unbalanced == pytest.approx(0.0, abs=1e-12)

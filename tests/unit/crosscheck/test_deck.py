"""Decks for CalculiX: what they say is what the scene says, in a form that CalculiX runs."""

import re
import shutil
from dataclasses import replace

import numpy as np
import pytest
from tests.fe_meshes import cube

from rollbench.compare.errors import InputError
from rollbench.compare.scenes import catalogue
from rollbench.compare.studies import export
from rollbench.compare.studies.crosscheck import study
from rollbench.compare.studies.crosscheck.deck import DeckOptions, build_deck
from rollbench.meshes import helix, parts
from rollbench.meshes.exchange import deck

pytestmark = pytest.mark.xdist_group("deck")

CCX = pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed")
COARSE = DeckOptions(b_over_h=0.7, growth=0.8)
#: Ends of the edges whose middles are a C3D10's nodes 5 to 10, and corners of its faces S1 to S4, from Abaqus' manual.
EDGES = ((1, 2), (2, 3), (3, 1), (1, 4), (2, 4), (3, 4))
FACES = ((1, 2, 3), (1, 4, 2), (2, 4, 3), (3, 4, 1))


def blocks(text: str) -> list[tuple[str, list[str]]]:
    """Keyword lines and their data lines; lines that go on are joined."""
    found: list[tuple[str, list[str]]] = []
    for line in text.splitlines():
        if line.startswith("**"):
            continue
        if line.startswith("*"):
            found.append((line, []))
        elif found[-1][1] and found[-1][1][-1].endswith(","):
            found[-1][1][-1] += line
        else:
            found[-1][1].append(line)
    return found


def table(text: str, head: str) -> np.ndarray:
    """Numbers below all keyword lines that begin with ``head``."""
    rows = [[float(x) for x in line.split(",")] for key, data in blocks(text) if key.startswith(head) for line in data]
    return np.array(rows)


def stack() -> deck.InputDeck:
    """Two unit cubes (1 mm) one on the other: the lower one held, the upper one pressed by 10 N."""
    points, cells = cube("P2", 1)
    faces, bodies = deck.outer_faces_of_tetrahedra(cells), []
    for name, low, end in (("LOW", 0.0, 0.0), ("HIGH", 1e-3, 2e-3)):
        x = 1e-3 * points + [0.0, 0.0, low]
        middle = faces[np.all(np.abs(x[faces][:, :, 2] - 1e-3) < 1e-9, axis=1)]
        ends = {f"{name}_END": np.flatnonzero(np.abs(x[:, 2] - end) < 1e-9)}
        bodies.append(deck.DeckBody(name, x, cells, parts.Material(1e9, 0.0), ends, {f"{name}_FACE": middle}))
    at, held, pressed = np.array([0.0, 0.0, 2e-3]), tuple((k, 0.0) for k in (0, 1, 3, 4, 5)), -10.0 * np.eye(6)[2]
    section = deck.RigidSection("PUSH", "HIGH", "HIGH_END", at, held, pressed, (2,))
    contact = ("HIGH_FACE", "LOW_FACE")
    return deck.InputDeck(
        tuple(bodies), (section,), ("LOW_END",), (contact,), 1e16, 1.0, ("a comment",), "two cubes of 1 mm³"
    )


def test_cells_and_faces_are_numbered_as_abaqus_does():
    text = deck.deck_text(stack())
    nodes, cells = table(text, "*NODE, NSET"), table(text, "*ELEMENT, TYPE=C3D10").astype(int)
    place = np.full((int(nodes[:, 0].max()) + 1, 3), np.nan)
    place[nodes[:, 0].astype(int)] = nodes[:, 1:]
    for row in cells[:, 1:]:
        for k, (a, b) in enumerate(EDGES):
            np.testing.assert_allclose(place[row[4 + k]], 0.5 * (place[row[a - 1]] + place[row[b - 1]]), atol=1e-12)
    (lines,) = [data for key, data in blocks(text) if key.startswith("*SURFACE, NAME=HIGH_FACE")]
    assert len(lines) == 2
    for line in lines:
        cell, face = line.split(", S")
        (row,) = cells[cells[:, 0] == int(cell), 1:]
        np.testing.assert_allclose(place[row[np.array(FACES[int(face) - 1]) - 1]][:, 2], 1.0, atol=1e-12)
    with pytest.raises(ValueError, match="belongs to no cell"):
        deck.cells_and_numbers_of_faces(stack().bodies[0].cells, np.array([[0, 0, 0]]))


def test_equations_of_a_section_are_those_of_a_rigid_motion():
    cubes = stack()
    text = deck.deck_text(cubes, "m")
    move, turn = np.array([1.0, -2.0, 3.0]), np.array([0.3, 0.5, -0.7])
    nodes = table(text, "*NODE, NSET")
    u = {int(n): move + np.cross(turn, x - cubes.rigid_sections[0].reference_point) for n, *x in nodes}
    first = max(u) - 1  # the last two nodes are the section's
    u[first], u[first + 1] = move, turn
    equations = [data for key, data in blocks(text) if key == "*EQUATION"]
    assert len(equations) == 3 * 9
    for count, terms in equations:
        found = np.array([float(x) for x in terms.split(",")]).reshape(-1, 3)
        assert int(count) == len(found)
        assert sum(c * u[int(n)][int(k) - 1] for n, k, c in found) == pytest.approx(0.0, abs=1e-12)


def test_units():
    cubes = stack()
    mm, m = deck.deck_text(cubes), deck.deck_text(cubes, "m")
    np.testing.assert_allclose(table(mm, "*NODE, NSET=LOW")[:, 1:], 1e3 * table(m, "*NODE, NSET=LOW")[:, 1:])
    for head, row, factor in (("*ELASTIC", (0, 0), 1e-6), ("*SURFACE BEHAVIOR", ..., 1e-9), ("*SPRING", 1, 1e-3)):
        assert table(mm, head)[row] == pytest.approx(factor * table(m, head)[row])


@CCX
@pytest.mark.parametrize("unit", ["mm", "m"])
def test_calculix_finds_what_a_stack_of_cubes_must_and_tells_where_it_fails(unit, tmp_path):
    length, text = {"mm": 1e-3, "m": 1.0}[unit], deck.deck_text(stack(), unit)
    found = study.solve_deck_or_read_result(text, tmp_path)
    assert list(found.forces) == ["HIGH_FACE"]
    assert found.forces["HIGH_FACE"] == pytest.approx((0.0, 0.0, 10.0), abs=1e-4)
    ((_, _, sunk),) = found.node_displacements["PUSH_MOVE"].values()
    # two cubes in a row, a contact of 1e16 Pa/m on 1 mm2, beside a spring of 1 N/m
    assert sunk * length == pytest.approx(-10.0 * (2e-3 / (1e9 * 1e-6) + 1.0 / (1e16 * 1e-6)), rel=1e-3)
    assert re.fullmatch(r"\d+\.\d+", found.version)
    assert study.solve_deck_or_read_result(f"** another comment\n{text}", tmp_path) == found  # read, not run again
    loose = replace(stack(), rigid_sections=(), contact_pairs=(), fixed_node_sets=("NOWHERE",))
    with pytest.raises(ValueError, match="CalculiX failed"):
        study.solve_deck_or_read_result(deck.deck_text(loose), tmp_path)


@CCX
def test_two_programs_find_one_compliance_of_the_nut_held_and_on_its_flange(tmp_path):
    options = DeckOptions(b_over_h=0.5, growth=0.9)
    scene = export.cut_balls_out_of_screw(catalogue.scene("lin-case1"), 16, 16)
    found = study.compare_nut_compliance(scene, tmp_path, options)
    assert np.ravel(found.theirs) == pytest.approx(3.3e-9, rel=0.2)  # m/N, one ball
    assert found.difference < 0.1
    assert "within 0.1 %" in found.sentence_on_agreement()
    wrong = replace(found, ours=(1.002 * np.array(found.ours)).tolist())
    assert "NOT within 0.1 %" in wrong.sentence_on_agreement()
    study.save_nut_compliance(tmp_path, found)
    np.testing.assert_allclose(study.load_nut_compliance(tmp_path).ours, found.ours, rtol=1e-7)
    nut = replace(scene.nut, flange=parts.Flange(64e-3, 5e-3, (26e-3, 30e-3), "right", 4e-3, bonded=True))
    scene = replace(scene, nut=nut, solid=replace(scene.solid, nut_held="flange face"))
    assert study.compare_nut_compliance(scene, tmp_path, options).difference < 0.1


def test_calculix_missing_is_told(monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda _: None)
    with pytest.raises(InputError, match="apt-get install calculix-ccx"):
        study.find_calculix_program()


@pytest.fixture(scope="module")
def meshed():
    return build_deck(catalogue.scene("two-balls"), COARSE)


def test_whole_bodies_of_a_scene_as_fine_as_asked_at_the_contacts(meshed):
    bodies = {b.name: b for b in meshed.deck.bodies}
    assert list(bodies) == ["SCREW", "NUT", "BALL1", "BALL2"]
    for name, azimuth in (("BALL1", 0.0), ("BALL2", np.pi)):
        ball = bodies[name]
        centre = np.array([20e-3 * np.cos(azimuth), 20e-3 * np.sin(azimuth), 7e-3])
        r = np.linalg.norm(ball.points - centre, axis=1)
        assert r.max() == pytest.approx(4.005e-3, abs=1e-9)  # really 5 um larger
        assert set(ball.face_sets) == {f"{name}_{s}" for s in ("SL", "SR", "NL", "NR")}
        outer = np.unique(deck.outer_faces_of_tetrahedra(ball.cells))
        assert np.all(np.abs(r[outer] - 4.005e-3) < 1e-8)
    for name, side, sign in (("SCREW", "SL", -1), ("NUT", "NR", 1)):
        away = bodies[name].points[bodies[name].face_sets[f"{name}_{side}_1"]].mean(axis=(0, 1)) - [20e-3, 0.0, 7e-3]
        assert np.all(np.sign(away[[0, 2]]) == sign)
        assert np.linalg.norm(away) == pytest.approx(4e-3, rel=0.02)
    bore = bodies["SCREW"].points[bodies["SCREW"].node_sets["SCREW_BORE"]]
    np.testing.assert_allclose(np.hypot(*bore[:, :2].T), 11e-3, rtol=1e-9)
    assert len(meshed.deck.contact_pairs) == 8
    # elements are as fine as asked at the contacts
    for corners in ball.face_sets.values():
        x = ball.points[corners]
        near = np.linalg.norm(x.mean(axis=1) - x.mean(axis=(0, 1)), axis=1) < meshed.contact_element_size
        assert np.median(np.linalg.norm(x[near, 0] - x[near, 1], axis=1)) < 1.6 * meshed.contact_element_size


def test_what_a_deck_cannot_say_is_refused(tmp_path):
    scene, cut = catalogue.scene("two-balls"), catalogue.scene("lin-case1-cut")
    displaced = replace(scene.errors, SL=replace(scene.errors.SL, roundness=(parts.FourierTerm(2.0, 1e-6),)))
    uneven = replace(scene.errors, NL=replace(scene.errors.NL, profile=(1e-6,)))
    (support,) = scene.supports
    aside = replace(scene, balls=replace(scene.balls, azimuths=(0.0, 3.0)))
    loose = replace(scene, supports=(replace(support, fixed=tuple(x for x in support.fixed if x[0] != "uy")),))
    for bad, options, words in (
        (catalogue.scene("lin-case1"), COARSE, "1 to 4 balls"),
        (replace(scene, errors=displaced), COARSE, "a displaced groove"),
        (replace(scene, errors=uneven), COARSE, "grooves of two radii"),
        (replace(scene, solid=replace(scene.solid, nut="rigid")), COARSE, r"solid\.nut"),
        (scene, DeckOptions(b_over_h=0.4, growth=1.5), "no face of the mesh lies within an expected contact"),
        (replace(cut, loads=(replace(cut.loads[0], at=0.0),)), COARSE, r"load at 0 mm; allowed: .* 381\.375 mm"),
        *((other, DeckOptions(half=True), "half: got") for other in (cut, aside, loose)),
    ):
        with pytest.raises(InputError, match=words):
            build_deck(bad, options)
    good = {"program": "ccx", "unit": "mm", "balls": "", "b_over_h": 1.5, "growth": 0.4, "stiffness": 2e8}
    for choices, key in (
        ({"program": "abaqus"}, "deck: got"),
        ({"unit": "inch"}, "unit: got"),
        ({"b_over_h": 0.0}, "b_over_h: got"),
        ({"growth": float("nan")}, "growth: got"),
        ({"balls": "5:3"}, "balls: got"),
        ({"balls": "a"}, "balls: got"),
        ({"out": tmp_path / "a.txt"}, "out: got"),
    ):
        with pytest.raises(InputError, match=key):
            export.write_calculix_deck(**{**good, "scene": scene, "out": tmp_path / "a.inp", **choices})
    assert not list(tmp_path.iterdir())


def test_the_real_grooves_are_larger_by_their_error():
    scene = catalogue.scene("two-balls")
    smaller = replace(scene.errors.SL, profile=(2e-6,))
    screw = build_deck(replace(scene, errors=replace(scene.errors, SL=smaller, SR=smaller)), COARSE).deck.bodies[0]
    flank = screw.points[screw.face_sets["SCREW_SL_1"].ravel()]
    centre = np.array([20e-3, 7e-3]) + 0.4e-3 * np.array([1.0, 1.0]) / np.sqrt(2.0)
    away = np.hypot(np.hypot(*flank[:, :2].T) - centre[0], flank[:, 2] - centre[1])
    np.testing.assert_allclose(away, 4.398e-3, atol=1e-9)


def test_a_cut_keeps_its_balls_where_they_were():
    scene = catalogue.scene("lin-case1")
    cut = export.cut_balls_out_of_screw(scene, 15, 17)
    whole, kept = helix.ball_layout(scene), helix.ball_layout(cut)
    np.testing.assert_allclose(kept.centre, whole.centre[14:17], atol=1e-12)
    assert cut.loads[0].force[2] == pytest.approx(5000.0 * 3 / 32)
    assert cut.loads[0].at == cut.supports[0].at == pytest.approx(cut.nut.position - cut.nut.length / 2.0 - 3.0 * 2.778e-3)
    assert export.parse_ball_range("15:17", scene) == (15, 17)
    for bad, key in (
        (catalogue.scene("bearing-9"), "track.lead"),
        (catalogue.scene("lin-random"), "errors"),
        (catalogue.scene("lin-case3-offset"), "supports"),
    ):
        with pytest.raises(InputError, match=key):
            export.cut_balls_out_of_screw(bad, 1, 2)


def test_the_command_writes_a_deck(tmp_path, command):
    out, cut = tmp_path / "cut.inp", ["--balls", "16:17", "--b-over-h", "0.7", "--growth", "0.8", "--unit", "m"]
    assert "4 contacts; units m, N, Pa" in command.said("export", "lin-case1", "--deck", "ccx", *cut, "--out", out)
    assert re.search(r"(?s)\*SURFACE, NAME=SCREW_SL_1.*\*CLOAD", out.read_text())


def test_a_half_is_held_in_its_plane(meshed):
    whole, half = meshed, build_deck(catalogue.scene("two-balls"), replace(COARSE, half=True))
    assert half.deck.symmetry_node_sets == ("SCREW_CUT", "NUT_CUT", "BALL1_CUT", "BALL2_CUT")
    assert not whole.deck.symmetry_node_sets
    held = [line for key, data in blocks(deck.deck_text(half.deck)) if key == "*BOUNDARY" for line in data]
    assert [line for line in held if "_CUT" in line] == [f"{name}, 2, 2" for name in half.deck.symmetry_node_sets]
    for body in half.deck.bodies:
        cut = body.node_sets[f"{body.name}_CUT"]
        assert np.abs(body.points[cut][:, 1]).max() < 1e-12
        assert body.points[:, 1].min() > -1e-12
        led = [n for name, n in body.node_sets.items() if name in ("SCREW_BORE", "NUT_HELD")]
        assert not any(np.intersect1d(cut, n).size for n in led)  # these follow their section, which stays in the plane
        for corners in body.face_sets.values():
            assert not np.isin(corners, cut).all(axis=1).any()
        for one, two, axis in body.nodes_with_equal_displacement:
            arm = body.points[one] - body.points[two]
            assert abs(np.cross(arm, np.eye(3)[axis])[1]) > 1e-3  # a turn about y parts the two nodes
    assert [len(b.nodes_with_equal_displacement) for b in half.deck.bodies] == [0, 0, 1, 1]
    assert 1.4 < whole.deck.node_count / half.deck.node_count < 2.0

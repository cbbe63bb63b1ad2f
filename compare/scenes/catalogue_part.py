"""Scene files that start from a row of a maker's table: what is printed is taken over, the rest is typical and marked so.

Load ratings go into the table ``rating``, which no model reads, and the rigidity into a comment. Balls are never counted
from a load rating.
"""

from __future__ import annotations

from math import ceil, floor, pi
from typing import Any

from rollbench.compare import files
from rollbench.compare.errors import ArgumentError
from rollbench.compare.scenes import makers, template
from rollbench.meshes.units import toml_text

#: Ball diameter over outside less bore diameter of a bearing, up to a contact angle of 40 deg and beyond (SNFA prints 0.21
#: to 0.32; bearings of screws have smaller balls), in steps of [mm].
RING_BALLS, INCH = (0.28, 0.22), 25.4 / 32.0

#: Part of the pitch circle that the balls fill (SNFA: 0.61 to 0.89); width over outside less bore diameter (ISO 15: 0.45 to
#: 0.55); radial distance of the inner ring's shoulder from the pitch circle in ball diameters, for the same angles.
RING_FILLING, WIDTH, SHOULDERS = 0.8, 0.5, (0.25, 0.07)

#: Words on the rigidities that Rexroth prints.
HALVED = "about half of what other makers print of such a nut, "

#: Conformity of the bearings' grooves, as in the templates of bearings.
CONFORMITY = 0.52


def scene_text_of_catalogue_part(name: str, kind: str = "") -> str:
    """Return the text of a scene file of a ball nut on a screw, or of bearings on a shaft, by a maker's name.

    Parameters
    ----------
    name
        Name of the nut or bearing in its catalogue.
    kind
        Kind of the scene; if empty, it follows from the nut or bearing.

    Returns
    -------
    str
        Text of the scene file.

    Raises
    ------
    InputError
        If the name is unknown or ambiguous, or the kind does not suit it.
    """
    kind = kind.replace("-", " ")
    part = makers.find_part(name, double=kind == "double nut")
    allowed = ("ball screw", "double nut") if part.is_nut else ("support bearings",)
    if kind and kind not in allowed:
        words = ", ".join(x.replace(" ", "-") for x in allowed)
        raise ArgumentError("kind", kind.replace(" ", "-"), f"{words}, for {part.label}", "leave --kind out")
    return scene_text_of_nut(part, kind) if part.is_nut else scene_text_of_bearings(part)


def scene_text_of_nut(part: makers.CataloguePart, kind: str = "") -> str:
    """Return the text of a scene file of a ball nut in a catalogue; ``kind``: ball screw, double nut, or as the nut is."""
    values = nut_dimensions(part)
    head = f"title = {toml_text(part.label.removesuffix(' double nut'))}\nsource = {toml_text(_source(part))}"
    if (kind or ("ball screw" if part.type == "single nut" else "double nut")) == "ball screw":
        return f"{template.ball_screw_text_of(values, head)}{_rating_text(part, 'rating')}"
    return template.double_nut_text_of(values, head, _rating_text(part, "sets.rating"))


def nut_dimensions(part: makers.CataloguePart) -> dict[str, Any]:
    """Return printed and typical dimensions of a nut and its screw, by the names of placeholders in template texts."""
    ball, pitch = makers.ball_and_pitch_diameter(part.table, part.row)
    outer, lead = part.number("diameter_mm"), part.number("lead_mm")
    assert outer is not None
    assert lead is not None
    number, each, on_starts = makers.read_circuits(part.row)
    side_by_side = number > 1 and (on_starts or lead >= outer)
    starts, circuits = (number, 1) if side_by_side else (1, number)
    given = "pitch diameter" if part.row["pitch_mm"] else "ball"
    printed = f"Nominal diameter, lead, {given}, circuits and turns are printed by {part.maker}"
    assumed = [f"{printed}; all else is usual for such a screw, by the rules in the comments of the file."]
    if not part.row["ball_mm"]:
        assumed.append("The ball is not printed: it is the stock size that fits the printed diameters and the lead.")
    if side_by_side and not on_starts:
        assumed.append("The circuits are on as many starts of the thread, as the lead is not below the nominal diameter.")
    if part.type == "offset preload":
        assumed.append("The halves of the nut, which an offset of the lead preloads, are two nuts at a distance.")
    if _has_misprint(part):
        assumed.append("The table lists a misprint of this nut: see the comments of the file.")
    values = template.dimensions_around_circuits(outer, lead, ball, round(pitch, 3), circuits, each, starts)
    values |= {
        "like": f"by the name {part.label}, with what is printed, and what is usual for it",
        "assumed": "\n".join(f"  {toml_text(text)}," for text in assumed),
        "ball_is": "printed"
        if part.row["ball_mm"]
        else "assumed: the stock size that fits the printed diameters and the lead",
        "circuits_are": "printed; gaps differ from maker to maker",
    }
    values["pitch_is"] = "printed" if part.row["pitch_mm"] else f"assumed: {values['pitch_is']}"
    if each == 1.0 and not side_by_side:
        values["filling_is"] = "; where a deflector takes a part of each turn, 0.65 to 0.9"
    if part.is_misprint("ball"):
        values["ball_is"] += "; doubtful, the table lists a misprint of this nut"
    if side_by_side:
        values["starts"] = f"starts = {starts}  # {'printed' if on_starts else 'assumed: one for each circuit'}"
        values["circuits_are"] = f"on each start; printed are {number} in all"
    if "L x" in part.base:
        values["hand"] = 'hand = "left"'
    return values


def _source(part: makers.CataloguePart) -> str:
    """Return the words on the source of a part's values for the key source."""
    through = ", through a program's table" if "program" in part.table.header["class"] else ""
    return f"catalogue of {part.maker}{through}"


def _has_misprint(part: makers.CataloguePart) -> bool:
    """Return whether the table lists any quantity of a part as a misprint."""
    return any(part.is_misprint(quantity) for quantity in ("C", "C0", "rigidity", "preload"))


def _rating_text(part: makers.CataloguePart, name: str) -> str:
    """Return the lines of a nut's table with the maker's load ratings, and the comment with his rigidity.

    ``name``: name of the table. Values that are listed as misprints are comments.
    """
    unit, lines = part.table.header["load_unit"], []
    for key, column in (("dynamic", "C"), ("static", "C0")):
        value, printed = (
            part.number(column, part.table.unit_factor("load_unit")),
            f"{column}, printed {part.row[column]} {unit}",
        )
        line = f'{key} = "{value / 1e3:.5g} kN"  # {printed}' if value else f"# {key}: not printed"
        lines.append(f"# {line}: a misprint by the table, not taken over" if part.is_misprint(column) else line)
    commented = all(line.startswith("#") for line in lines)
    head = f"{'# ' if commented else ''}[{name}]  # by {part.maker}, shown beside the computed ones; no model reads it"
    return "\n".join(("", head, *lines, *_rigidity_lines(part))) + "\n"


def _rigidity_lines(part: makers.CataloguePart) -> list[str]:
    """Return comments with a nut's printed rigidity; with several, one for each preload."""
    printed = part.row.get("rigidity")
    label = f"# rigidity by {part.maker}, {HALVED if part.maker == 'Rexroth' else ''}which no model reads"
    if printed:
        header = part.table.header
        key = "rigidity_at" if part.type == "single nut" else "rigidity_at_preloaded"
        at = header.get(key, header["rigidity_at"])
        stated = f"{printed} {header['rigidity_unit']} ({at})"
        wrong = ": a misprint by the table" if part.is_misprint("rigidity") else ""
        return [f"{label}: {stated}{wrong}"]
    return [
        f"{label}: {rigidity:g} N/um at a preload of {share:g} % of C"
        for share, rigidity in makers.printed_rigidities_of_preloads(part)
    ]


def scene_text_of_bearings(part: makers.CataloguePart) -> str:
    """Return the text of a scene file of a preloaded pair or set of bearings in a catalogue, on a short shaft."""
    row, preload = part.row, makers.preload_of_bearing(part)
    bore, outside = part.number("bore_mm"), part.number("outside_diameter_mm")
    angle = float(row.get("angle_deg") or part.table.header["angle"])
    assert bore is not None
    assert outside is not None
    pitch, space = 0.5 * (bore + outside), outside - bore
    arrangement = makers.arrangement_of_row(part.table, row)
    share, shoulder = RING_BALLS[angle > 40.0], SHOULDERS[angle > 40.0]
    ball = part.number("ball_diameter_mm") or round(floor(share * space / INCH) * INCH, 3)
    count = int(part.number("balls") or floor(RING_FILLING * pi * pitch / ball))
    width = round(WIDTH * space)
    length = 50.0 * ceil(2.0 * len(arrangement) * width / 50.0)
    unprinted = "width, pitch and shoulder diameter, conformity" + ("" if row.get("balls") else ", balls")
    assumed = [f"What {part.maker} does not print ({unprinted}) is usual, by the rules in the comments of the file."]
    if _has_misprint(part):
        assumed.append("The table lists a misprint of these bearings: see the comments of the file.")
    values = {
        "label": part.label,
        "source": toml_text(_source(part)),
        "assumed": "\n".join(f"  {toml_text(text)}," for text in assumed),
        "length": length,
        "middle": 0.5 * length,
        "bore": bore,
        "outside": outside,
        "pitch": pitch,
        "conformity": CONFORMITY,
        "force": preload,
        "arrangement": arrangement,
        "preload_class": "" if row["preload_class"] == "-" else f", class {row['preload_class']}",
        "rigidity": _bearing_rigidity(part),
        "angle": angle,
        "shoulder": round(pitch - 2.0 * shoulder * ball, 2),
        "shoulder_of": shoulder,
        "width": width,
        "width_of": WIDTH,
        "ball": ball,
        "ball_is": "printed" if row.get("balls") else f"assumed: {share:g} of outside less bore, in 1/32 inch",
        "count": count,
        "count_is": "printed" if row.get("balls") else f"assumed: they fill {RING_FILLING:g} of the pitch circle",
    }
    return files.shipped_text("scenes/like_texts/bearings.txt").format(**values) + _bearing_rating_text(part)


def _bearing_rigidity(part: makers.CataloguePart) -> str:
    """Return a comment with the printed rigidity of a pair or set of bearings."""
    row = part.row
    given = row.get("rigidity_N_per_um") or row["Ra_pair_daN_per_um"]
    unit = "N/um" if "rigidity_N_per_um" in row else "daN/um"
    wrong = ": a misprint by the table" if part.is_misprint("rigidity") else ""
    return f"rigidity by {part.maker} at this preload, which no model reads: {given} {unit}{wrong}"


def _bearing_rating_text(part: makers.CataloguePart) -> str:
    """Return the lines of the table with the radial load ratings of one row; empty if they are not printed."""
    for names, unit in ((("Cr_kN", "C0r_kN"), 1.0), (("C33_daN", "C0_daN"), 0.01)):
        dynamic, static = (part.number(column, unit) for column in names)
        if dynamic and static:
            head = f"\n[sets.rating]  # radial, of one row, by {part.maker}, beside the computed ones; no model reads it"
            return f'{head}\ndynamic = "{dynamic:g} kN"\nstatic = "{static:g} kN"\n'
    return ""

"""The sections of the report, in order, and what each needs."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Part:
    """A section of the report by name: its module in ``compare.sections``; long: left out of a quick report; runs: shows
    runs of the 3D reference; meshes: needs gmsh; meshed: what of it needs gmsh, where the rest does not; appendix: stands
    after the others; beside: may be made by a second process."""

    name: str
    module: str
    long: bool = False
    runs: bool = False
    meshes: bool = False
    meshed: str = ""
    appendix: bool = False
    beside: bool = False


#: Sections in order.
PARTS = (
    Part("overview", "overview", runs=True, beside=True),
    Part("ladder", "ladder", runs=True, meshes=True, beside=True),
    Part("reference", "reference", runs=True, meshes=True, beside=True),
    Part("reference-mesh", "reference_mesh", runs=True, beside=True),
    Part("u-val", "u_val", runs=True, meshes=True, beside=True),
    Part("crosscheck", "crosscheck", long=True, runs=True, meshes=True, beside=True),
    Part("pictures", "pictures", long=True, meshes=True),
    Part("hertz", "hertz"),
    Part("cases", "cases", runs=True),
    Part("errors", "errors"),
    Part("manufacturing", "manufacturing"),
    Part("steering", "steering"),
    Part("tolerances", "tolerances"),
    Part("friction", "friction"),
    Part("friction-screw", "friction_screw"),
    Part("rolling", "rolling", meshed="no motion against the static reference, sizes of bodies", beside=True),
    Part("smith", "smith"),
    Part("liu", "liu"),
    Part("external", "external", runs=True),
    Part("formulations", "formulations"),
    Part("verification", "verification", meshes=True),
    Part("stability", "stability", long=True),
    Part("timing", "timing", long=True),
    Part("history", "history", runs=True, beside=True),
    Part("verdicts", "verdicts", runs=True, appendix=True),
    Part("audit", "audit", runs=True, appendix=True),
    Part("notes", "notes", runs=True, appendix=True),
)
SECTIONS = tuple(part.name for part in PARTS)

"""The sections of the report, in order, and what each needs."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Part:
    """A section of the report by name: its module in ``compare``; long: left out of a quick report; runs: shows
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
    Part("overview", "sections.overview", runs=True, beside=True),
    Part("ladder", "sections.ladder", runs=True, meshes=True, beside=True),
    Part("reference", "sections.reference", runs=True, meshes=True, beside=True),
    Part("reference-mesh", "sections.reference_mesh", runs=True, beside=True),
    Part("u-val", "sections.u_val", runs=True, meshes=True, beside=True),
    Part("crosscheck", "wings.crosscheck.section", long=True, runs=True, meshes=True, beside=True),
    Part("pictures", "sections.pictures", long=True, meshes=True),
    Part("hertz", "sources.lin.sections.hertz"),
    Part("cases", "sources.lin.sections.cases", runs=True),
    Part("errors", "sources.lin.sections.errors"),
    Part("manufacturing", "sources.lin.sections.manufacturing"),
    Part("steering", "sources.lin.sections.steering"),
    Part("tolerances", "wings.sweep.section"),
    Part("friction", "sources.lin.sections.friction"),
    Part("friction-screw", "sources.lin.sections.friction_screw"),
    Part(
        "rolling", "sources.kalker.section", meshed="no motion against the static reference, sizes of bodies", beside=True
    ),
    Part("smith", "sources.smith.section"),
    Part("liu", "sources.liu.section"),
    Part("external", "sources.external.section", runs=True),
    Part("formulations", "sources.lin.sections.formulations"),
    Part("verification", "sections.verification", meshes=True),
    Part("stability", "wings.extremes.section", long=True),
    Part("timing", "wings.bench.section", long=True),
    Part("history", "sections.history", runs=True, beside=True),
    Part("verdicts", "sections.verdicts", runs=True, appendix=True),
    Part("audit", "sections.audit", runs=True, appendix=True),
    Part("notes", "sections.notes", runs=True, appendix=True),
)
SECTIONS = tuple(part.name for part in PARTS)

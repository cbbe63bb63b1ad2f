"""What is computed for the printed tables of other programs, makers and textbooks: function, test, scenes."""

from __future__ import annotations

from rollbench.comparison.evidence.registry import Computation

EXTERNAL = "tests/literature/test_external.py"
CATALOGUE = "formulas on the catalogue's data: compare/sources/external/cases.toml"
#: Sizes of THK and one of HIWIN: names of scenes after the prefix and the maker.
NUTS = ("thk-bnf-4010-5", "thk-bnf-4010-3p5", "thk-bnf-3205-2p5", "thk-bnf-3205-5", "thk-bnf-3205-7p5", "hiwin-63-10k5")

COMPUTATIONS = (
    Computation(
        "external-masta",
        "sources.external.evidence.bearings:masta",
        EXTERNAL,
        (
            ("radial", ("external-masta-radial",)),
            ("axial", ("external-masta-axial",)),
            ("tilt", ("external-masta-moment",)),
        ),
        needs=("bearings",),
    ),
    Computation(
        "external-nsk",
        "sources.external.evidence.contacts:ball_of_bearing",
        EXTERNAL,
        (("*", ("external-nsk-25bswz01",)),),
        needs=("bearings", "rolling"),
    ),
    Computation(
        "external-harris",
        "sources.external.evidence.bearings:harris",
        EXTERNAL,
        (("*", ("external-harris-218",)),),
        needs=("bearings",),
    ),
    Computation(
        "external-sjovall",
        "sources.external.evidence.bearings:half_zone",
        EXTERNAL,
        (
            ("radial", ("external-sjovall-radial",)),
            ("thrust", "closed form: thrust shared evenly"),
            ("*", ("external-sjovall-combined",)),
        ),
        needs=("bearings",),
    ),
    Computation(
        "external-contact",
        "sources.external.evidence.contacts:rolling",
        EXTERNAL,
        (("*", "one contact, the example of the program"),),
        needs=("bearings", "rolling"),
    ),
    Computation(
        "external-vm63",
        "sources.external.evidence.contacts:sphere",
        EXTERNAL,
        (("*", "one contact, Hertz's closed form"),),
        needs=("bearings", "rolling"),
    ),
    Computation(
        "external-snfa", "sources.external.evidence.bearings:snfa", EXTERNAL, (("*", CATALOGUE),), needs=("bearings",)
    ),
    Computation(
        "external-gmn", "sources.external.evidence.bearings:gmn", EXTERNAL, (("*", CATALOGUE),), needs=("bearings",)
    ),
    Computation(
        "external-thk",
        "sources.external.evidence.screws:nuts",
        EXTERNAL,
        (
            *((f"*_{name.removeprefix('thk-')}", (f"external-{name}",)) for name in NUTS),
            ("turns_5", ("external-thk-bnf-3205-5", "external-thk-bnf-3205-2p5")),
            ("turns_7p5", ("external-thk-bnf-3205-7p5", "external-thk-bnf-3205-2p5")),
            ("drag_formula", ()),
            ("*", ("external-thk-bnf-4010-5",)),
        ),
        needs=("friction",),
    ),
)

"""What the wing of mesh studies adds."""

from rollbench.compare.registration import Part, Registration

REGISTRATION = Registration(
    commands={"mesh-study": "wings.mesh_study.arguments"},
    parts=(Part("reference-mesh", "wings.mesh_study.section", quick=True, runs=True, page="reference"),),
    functions={"mesh study": "wings.mesh_study.command:library"},
)

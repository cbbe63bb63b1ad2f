"""Functions of ``import rollbench``: read and solve scenes, compare models with the 3D reference."""

from rollbench.compare.api.calls import (
    check,
    compare_models,
    ensemble,
    friction,
    load_curve,
    mesh_study,
    new,
    read,
    side_by_side,
    solve,
    survey,
    sweep,
    table,
)

__all__ = [
    "check",
    "compare_models",
    "ensemble",
    "friction",
    "load_curve",
    "mesh_study",
    "new",
    "read",
    "side_by_side",
    "solve",
    "survey",
    "sweep",
    "table",
]

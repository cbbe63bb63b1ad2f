"""Table of the times of the verification runs: the mesh's name and the time of meshing are two columns."""

from types import SimpleNamespace

from rollbench.compare.sections import verification


def test_the_column_mesh_names_the_mesh():
    seconds = {name: 0.5 + k for k, name in enumerate(verification.TIMES)}
    run = SimpleNamespace(job="A", b_over_h=2.0, seconds=seconds)
    table = verification.times_table([verification.Level("27-node hexahedra", run, {})])
    (row,) = table.rows
    keys = [column.key for column in table.columns]
    assert len(set(keys)) == len(keys) == len(row)
    assert len({column.label for column in table.columns}) == len(keys)
    assert row["mesh"] == "27-node hexahedra"
    assert row["mesh_seconds"] == seconds["mesh"]
    assert [row[f"{name}_seconds"] for name in verification.TIMES] == list(seconds.values())

"""From a catalogue page to loads, stiffness and pressure: python -m compare.examples.catalogue_page"""

from __future__ import annotations

from pathlib import Path

import rollbench


def main() -> rollbench.Solution:
    """Solve it and print the answers."""
    solution = rollbench.solve(Path(__file__).with_name("catalogue_page.toml"))
    for name, unit in (
        ("axial.displacement", "um"),
        ("axial.rigidity", "N_per_um"),
        ("worst_contact.pressure", "MPa"),
        ("preload.mean", "N"),
    ):
        words, value = name.split(".")[1], solution[f"summary.{name}_{unit}"]
        print(f"{words:15} {value:.4g} {unit.replace('_per_', '/')}")
    return solution


if __name__ == "__main__":
    main()

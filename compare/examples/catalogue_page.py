"""From a catalogue page to loads, stiffness and pressure: python -m compare.examples.catalogue_page"""

from __future__ import annotations

from pathlib import Path

import rollbench


def main() -> rollbench.Result:
    """Solve it and print the answers."""
    solution = rollbench.solve(Path(__file__).with_name("catalogue_page.toml"))
    for name in ("axial.displacement_um", "axial.rigidity_N_per_um", "worst_contact.pressure_MPa", "preload.mean_N"):
        print(f"{name.split('.')[1].rsplit('_')[0]:15} {solution.quantity(f'summary.{name}'):.4g~P}")
    return solution


if __name__ == "__main__":
    main()

"""From a catalogue page to loads, stiffness and pressure: ``python -m compare.examples.catalogue_page``."""

from __future__ import annotations

from pathlib import Path

import rollbench


def main() -> rollbench.Result:
    """Solve the screw of the catalogue page, and print displacement, rigidity, pressure and preload."""
    result = rollbench.solve(Path(__file__).with_name("catalogue_page.toml"))
    if result.nut is not None and result.nut.displacement is not None and result.nut.secant is not None:
        print(f"displacement {1e6 * result.nut.displacement:.4g} um, rigidity {1e-6 * result.nut.secant:.4g} N/um")
    if result.worst is not None and result.preload is not None:
        print(f"pressure {1e-6 * result.worst.pressure:.4g} MPa, preload {result.preload.mean:.4g} N a contact")
    return result


if __name__ == "__main__":
    main()

"""Section 4.3.2, pitch against roundness errors: printed numbers and claims on both screws."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rollbench.compare.evidence.record import Sheet, count_of
from rollbench.compare.models.study import Study
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Scene, SideErrors, Support

SCREWS = {"4p1": "Table 4.1", "2p1": "Table 2.1"}
#: Clearances tried for the claim of two-point contact: change of every ball's radius [m].
CLEARANCES = (0.0, -1e-6, -2e-6, -3e-6, -4e-6, -5e-6)


def spread(result: StaticResult) -> float:
    """Standard deviation of the loads on SL over their mean."""
    return float(result.load[:, 0].std() / result.load[:, 0].mean())


def unloaded(result: StaticResult) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Balls without any contact."""
    return np.asarray(result.load.sum(axis=1) == 0.0)


def cycles(scene: Scene, lost: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> tuple[int, float]:
    """Dominant number of cycles per turn (1 to 4) in the pattern of lost balls, and its share of the power."""
    phi = ball_layout(scene).azimuth
    x = lost.astype(float) - lost.mean()
    power = np.array([np.abs((x * np.exp(-1j * k * phi)).sum()) ** 2 for k in range(1, 5)])
    if power.sum() == 0.0:
        return 0, 0.0
    return int(power.argmax()) + 1, float(power.max() / power.sum())


def readings(scene: Scene) -> list[tuple[str, Scene]]:
    """Supports and clearances that the source does not print."""
    rotation = (Support(0.0, (("rz", 0.0),)),)
    lateral = (Support(0.0, (("ux", 0.0), ("uy", 0.0), ("rz", 0.0))),)
    no_right = replace(scene.errors, SR=SideErrors())
    out = [
        ("as shipped: left end clamped but for axial motion", scene),
        ("left end: only rotation about the axis held", replace(scene, supports=rotation)),
        ("left end: lateral displacement and rotation about the axis held", replace(scene, supports=lateral)),
        ("error on SL only, as the formula is printed", replace(scene, errors=no_right)),
    ]
    for c in CLEARANCES[1:]:
        errors = replace(scene.errors, balls=replace(scene.errors.balls, oversize=c))
        out.append((f"ball radius smaller by {-1e6 * c:.0f} um", replace(scene, errors=errors)))
    return out


def section_4_3_2(sheet: Sheet, study: Study) -> None:
    """Numbers and claims of 4.3.2."""
    pitch, roundness = study.scene("lin-pitch-4p1"), study.scene("lin-roundness-4p1")
    sheet.number("e_p", 1e6 * pitch.errors.SL.pitch[0].sin, "key of the scene")
    sheet.number("e_R", 1e6 * roundness.errors.SL.roundness[0].sin, "key of the scene")
    sheet.number("force", pitch.loads[0].force[2], "key of the scene")
    for screw in SCREWS:
        _claims(study, sheet, screw)


def _claims(study: Study, sheet: Sheet, screw: str) -> None:
    pitch, roundness = study.solve(f"lin-pitch-{screw}"), study.solve(f"lin-roundness-{screw}")
    third = [float(r.load[:, [1, 2]].max()) for r in (pitch, roundness)]
    sheet.claim(
        f"two_point_{screw}",
        max(third) == 0.0,
        f"a third contact carries up to {third[0]:.1f} N (pitch) and {third[1]:.1f} N (roundness); "
        "with clearance it vanishes, see table manufacturing-readings",
    )
    sheet.claim(
        f"less_uniform_{screw}",
        spread(roundness) > spread(pitch),
        f"standard deviation over mean {spread(roundness):.2f} with roundness, {spread(pitch):.2f} with pitch error",
    )
    lost = unloaded(roundness)
    words = f"{count_of(lost)} balls without contact; with pitch error {count_of(unloaded(pitch))}"
    sheet.claim(f"lost_{screw}", bool(lost.any()), words)
    count, power = cycles(study.scene(f"lin-roundness-{screw}"), lost)
    words = f"{power:.0%} of the pattern's power is at {count} cycles per turn" if lost.any() else "no ball loses contact"
    sheet.claim(f"pattern_{screw}", bool(lost.any()) and count == 2, words)

"""Which drawn and shipped screws the refined model is further off than 1.5 % (largest) or 0.5 % (RMS) of the mean load."""

import pytest

from rollbench.compare.measure import load_error
from rollbench.compare.models.registry import Options, run_model
from rollbench.compare.models.study import Study
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.sections.grid_coverage import judges, levelled
from rollbench.lowfi.statics.nominal import nominal_contacts

pytestmark = pytest.mark.xdist_group("grid_coverage")

#: Those beyond the line on their finest level, their errors [% of the mean load, largest and RMS] and the cause.
BEYOND = {
    # 16x16 with a bore of 6 mm, clamped at both ends, the right one displaced by 171 um: many times the contact approach,
    # so that 1 % of the shaft's stiffness is some per cent of a light load. (13.9 and 4.0 % while the 3D shaft beyond the
    # nut sheared as if it had no bore.)
    "survey-20360-37": (8.40, 2.45),
    # 40x10, a nut of one turn under a moment on the shaft's section at its centre: contacts below that section feel the
    # shaft's contraction, those above do not, so that the error leaps by 3 % from one ball to the next. (With a step
    # smoothed by Saint-Venant's slowest mode 1.66 and 0.82 %: without a leap, and too tilted.)
    "survey-20360-130": (1.95, 0.75),
}
LARGEST, RMS = 1.5, 0.5


@pytest.mark.slow
def test_screws_beyond_the_line_are_these() -> None:
    study, drawn, found = Study(), judges(shipped_store())[1], {}
    for name, loads in levelled(study).items():
        scene = drawn.get(name) or study.scene(name)
        result = run_model(scene, "refined", Options(discretisation=False))
        error = load_error(result.load, loads[max(loads)], nominal_contacts(scene))
        if error.max_percent > LARGEST or error.rms_percent > RMS:
            found[name] = (error.max_percent, error.rms_percent)
    assert set(found) == set(BEYOND)
    for name, errors in BEYOND.items():
        assert found[name] == pytest.approx(errors, abs=0.06)

"""Which drawn and shipped screws the refined model is further off than 1.5 % (largest) or 0.5 % (RMS) of the mean load."""

import pytest

from rollbench.comparison.measure import load_error
from rollbench.comparison.models.grid_coverage import judges, levelled
from rollbench.comparison.models.registry import Options, run_model
from rollbench.comparison.models.study import Study
from rollbench.comparison.reference.store import shipped_store
from rollbench.lowfi.statics.nominal import nominal_contacts

pytestmark = pytest.mark.xdist_group("grid_coverage")

#: Those beyond the line on their finest level, their errors [% of the mean load, largest and RMS] and the cause.
BEYOND = {
    # 16x16 with a bore of 6 mm, clamped at both ends, the right one displaced by 171 um: the 3D shaft beyond the nut shears
    # as if it had no bore (1.5 times too stiff). With that shear in the model too, 3.9 and 1.7 %.
    "survey-20360-37": (13.95, 3.99),
    # Loads of the judging levels are from before a moment at the nut acted on a slice of the screw; by the survey's run,
    # which is later, 0.53 and 0.24 %.
    "survey-20360-109": (2.18, 1.23),
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

"""Friction torque: units, powers, and the equality of two forms of Palmgren's formula."""

import numpy as np
import pytest

from rollbench.lowfi.bearings import torque

RPM = np.pi / 30.0
INCH_POUND = 0.0254 * 4.4482216152605


def test_viscous_torque_in_its_own_units_of_films_that_are_not_too_thin():
    """1e-8 kg f (nu n)^(2/3) d^3 in mm: 1000 mm^2/s rpm^... counted by hand for round numbers."""
    found = torque.viscous_torque(2.0, 50e-3, 27e-6, 1000.0 * RPM)
    assert found == pytest.approx(1e-8 * 2.0 * 27000.0 ** (2 / 3) * 50.0**3 * torque.KILOGRAM_FORCE * 1e-3, rel=1e-12)
    assert found == pytest.approx(1e-8 * 2.0 * 900.0 * 125000.0 * 9.80665e-3, rel=1e-12)
    torque.viscous_torque(2.0, 50e-3, 1e-6, 2001.0 * RPM)
    with pytest.raises(ValueError, match="at least 2000"):
        torque.viscous_torque(2.0, 50e-3, 1e-6, 1999.0 * RPM)


def test_both_forms_agree_with_the_exponent_two_thirds_only():
    """2.31: f p d^3 (eta omega/p)^x in kg, mm, s, p one atmosphere, oil of 900 kg/m3, against 2.32."""
    nu, n, dm = 27.0, 1450.0, 55.086
    atmosphere = 101325.0 / torque.KILOGRAM_FORCE * 1e-6
    eta = nu * 1e-6 * 900.0 / torque.KILOGRAM_FORCE * 1e-6

    def pressure_form(x):
        return 2.0 * atmosphere * dm**3 * (eta * n * RPM / atmosphere) ** x * torque.KILOGRAM_FORCE * 1e-3

    ours = torque.viscous_torque(2.0, dm * 1e-3, nu * 1e-6, n * RPM)
    assert pressure_form(2.0 / 3.0) == pytest.approx(ours, rel=0.03)
    assert pressure_form(1.5) < 1e-3 * ours


def test_static_rating_and_load_torque():
    across, along = 1.0 / 0.1, 1.0 / 4e-3
    c = torque.static_rating(2, 18, 8e-3, np.radians(60.0), across, along)
    k = 2.8 / (8.0 * np.sqrt(across * along) * 1e-3)  # kg/mm^2
    assert c == pytest.approx(k * 2 * 18 * np.sin(np.radians(60.0)) * 64.0 * torque.KILOGRAM_FORCE, rel=1e-12)
    t = torque.load_torque(4e3, 1e3, 55e-3, c)
    assert t.equivalent_load == pytest.approx(0.5 * 1e3 + 0.3 * 4e3)
    assert t.factor == pytest.approx(0.0013 * (t.equivalent_load / c) ** (1 / 3))
    assert t.torque == pytest.approx(t.factor * 4e3 * 55e-3)
    # without radial load it grows with the 4/3 power
    assert torque.load_torque(8e3, 0.0, 55e-3, c).torque / torque.load_torque(1e3, 0.0, 55e-3, c).torque == pytest.approx(
        16.0
    )


def test_taper_torque_in_its_own_units():
    """1000 rpm, 10 cP, 1000 lb, G_1 = 100: 3.54e-3 (1e4)^0.62 1000^0.3 in-lb."""
    found = torque.taper_torque(100.0, 10e-3, 1000.0 * RPM, 1000.0 * 4.4482216152605)
    assert found / INCH_POUND == pytest.approx(3.54e-3 * 1e4**0.62 * 1000.0**0.3, rel=1e-12)
    assert torque.taper_geometry(found, 10e-3, 1000.0 * RPM, 1000.0 * 4.4482216152605) == pytest.approx(100.0, rel=1e-12)

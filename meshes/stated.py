"""Numbers that a scene file states in place of those that the records hold, and the way back.

Number and turns of balls in place of their azimuths, the clearance of a bearing in place of its contact angle, the
conformity of a groove in place of its radius.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import acos, asin, cos, pi, sin

from rollbench.meshes import ranges
from rollbench.meshes.scene_text import Table, with_unit

#: Contact angle [rad] that stands for the angle 0 of a single arc. Its sign gives the direction in which thrust changes the
#: contact angle; its size has no effect.
LEAST = 1e-7


def evenly_spaced_azimuths(
    balls_of_circuit: int, turns: float, helix_azimuth: float, circuits: int = 1, circuit_gap: float = 0.0
) -> tuple[float, ...]:
    """Return the azimuths of balls that are evenly spaced over the loaded turns of each ball circuit.

    Parameters
    ----------
    balls_of_circuit : int
        Number of loaded balls in one circuit.
    turns : float
        Number of loaded turns of one circuit.
    helix_azimuth : float
        Azimuth of the middle of all circuits together [rad].
    circuits : int, default 1
        Number of circuits of one thread start.
    circuit_gap : float, default 0.0
        Number of turns without balls between two circuits.

    Returns
    -------
    tuple[float, ...]
        Azimuths [rad], ascending.

    Examples
    --------
    >>> from math import degrees
    >>> [round(degrees(x)) for x in evenly_spaced_azimuths(4, 1.0, 0.0)]
    [-135, -45, 45, 135]
    """
    spacing, pitch = 2.0 * pi * turns / balls_of_circuit, 2.0 * pi * (turns + circuit_gap)
    middles = (helix_azimuth + (k - (circuits - 1) / 2.0) * pitch for k in range(circuits))
    return tuple(
        middle + (i - (balls_of_circuit - 1) / 2.0) * spacing for middle in middles for i in range(balls_of_circuit)
    )


def ball_spacing_table(azimuths: Sequence[float], phase: float, starts: int) -> Table:
    """Return the keys that state the positions of balls: number and turns where they are evenly spaced, else azimuths.

    Parameters
    ----------
    azimuths : Sequence[float]
        Azimuths of the balls of one thread start [rad].
    phase : float
        Azimuth of the helix at the nut's centre [rad].
    starts : int
        Number of thread starts.

    Returns
    -------
    Table
        The keys ``count``, ``turns`` and, for several circuits, ``circuits`` and ``circuit_gap``; or ``azimuths``.

    Examples
    --------
    >>> ball_spacing_table(evenly_spaced_azimuths(4, 1.0, 0.0), 0.0, 2)
    {'count': 8, 'turns': 1.0}
    """
    apart = [b - a for a, b in pairwise(azimuths)]
    each = next((i for i, x in enumerate(apart, 1) if abs(x - apart[0]) > 1e-6 * abs(apart[0])), len(azimuths))
    turns = 1.0 if each == 1 else float(f"{each * apart[0] / (2.0 * pi):.9g}")
    circuits = len(azimuths) // each
    gap = float(f"{(azimuths[each] - azimuths[0]) / (2.0 * pi) - turns:.9g}") if circuits > 1 else 0.0
    if tuple(azimuths) != evenly_spaced_azimuths(each, turns, phase, circuits, gap):
        return {"azimuths": [with_unit(ranges.Azimuth, azimuth) for azimuth in azimuths]}
    several = {"circuits": circuits, "circuit_gap": gap} if circuits > 1 else {}
    return {"count": len(azimuths) * starts, "turns": turns} | several


def free_contact_angle(centre_distance: float, radial_clearance: float | None, axial_clearance: float | None) -> float:
    """Compute the contact angle alpha of an unloaded bearing with single-arc grooves from its internal clearance.

    The radial clearance is P_d = 2 A (1 - cos alpha), the axial one P_e = 2 A sin alpha.

    Parameters
    ----------
    centre_distance : float
        Distance A between the groove centres of both rings when a ball touches both [m], from
        `one_arc.distance_of_groove_centres`.
    radial_clearance : float | None
        Radial internal clearance P_d [m]; used where ``axial_clearance`` is None.
    axial_clearance : float | None
        Axial internal clearance P_e [m]; None: the radial clearance is used.

    Returns
    -------
    float
        Contact angle [rad], at least `LEAST`.

    Raises
    ------
    ValueError
        The clearance is 2 A or more; the message gives this limit.

    References
    ----------
    Harris and Kotzalas (2007), sections 2.3 and 2.4.

    Examples
    --------
    >>> from math import degrees
    >>> round(degrees(free_contact_angle(0.18e-3, 13e-6, None)), 2)
    15.44
    """
    share = (radial_clearance if axial_clearance is None else axial_clearance or 0.0) or 0.0
    if not share < 2.0 * centre_distance:
        direction = "radial" if axial_clearance is None else "axial"
        raise ValueError(
            f"the {direction} clearance must be below {2e3 * centre_distance:.4g} mm, at which the contact angle reaches "
            "90 deg"
        )
    ratio = share / (2.0 * centre_distance)
    return max(acos(1.0 - ratio) if axial_clearance is None else asin(ratio), LEAST)


def clearance_table(centre_distance: float, contact_angle: float) -> Table:
    """Return the key that states the contact angle of an unloaded bearing with single-arc grooves: its shortest clearance.

    Parameters
    ----------
    centre_distance : float
        Distance A between the groove centres of both rings when a ball touches both [m].
    contact_angle : float
        Contact angle [rad], which `free_contact_angle` computes from the clearance.

    Returns
    -------
    Table
        The key ``clearance`` with a radial or axial clearance.

    Examples
    --------
    >>> clearance_table(0.18e-3, free_contact_angle(0.18e-3, 13e-6, None))
    {'clearance': {'radial': '13 um'}}
    """
    twice = 2.0 * centre_distance
    ways = {"radial": twice * (1.0 - cos(contact_angle)), "axial": twice * sin(contact_angle)}
    for digits in range(2, 18):
        for way, size in ways.items():
            found = float(f"{size:.{digits}g}")
            radial, axial = (found, None) if way == "radial" else (None, found)
            if free_contact_angle(centre_distance, radial, axial) == contact_angle:
                return {"clearance": {way: with_unit(ranges.Clearance, found)}}
    return {"clearance": {"radial": with_unit(ranges.Clearance, ways["radial"])}}


def groove_table(radius: float, ball: float) -> Table:
    """Return the key that states a groove's radius r_G: as conformity r_G / (2 r_B) where that is shorter and exact.

    Parameters
    ----------
    radius, ball : float
        Radii r_G of the groove and r_B of the ball [m].

    Returns
    -------
    Table
        The key ``conformity`` or ``groove_radius`` with its value.

    Examples
    --------
    >>> groove_table(0.52 * 2.0 * 2.7765e-3, 2.7765e-3), groove_table(3.254e-3, 2.778e-3)
    ({'conformity': 0.52}, {'groove_radius': '3.254 mm'})
    """
    text, conformity = with_unit(ranges.Size, radius), float(f"{radius / (2.0 * ball):.9g}")
    shorter = len(str(conformity)) < len(str(text)) - 3 and conformity > 0.5
    if shorter and conformity * (2.0 * ball) == radius:
        return {"conformity": with_unit(ranges.Conformity, conformity)}
    return {"groove_radius": text}

"""What results of friction leave out: of a whole screw or bearing, and of each kind of scene that only friction solves."""

from __future__ import annotations

LUBRICANT = "lubricant: film thickness, churning, and a coefficient that depends on speed, slip and temperature"
HYSTERESIS = "rolling hysteresis of the materials"
PARTS = "cage or spacers, return tube or deflectors, wipers and seals"
INERTIA = "gyroscopic moments and centrifugal forces of the balls"

#: What a whole screw or bearing leaves out at its instant.
WHOLE = (
    "feedback of friction on how the balls share the load: each keeps the load that it carries without friction",
    LUBRICANT,
    HYSTERESIS,
    "Heathcote slip over the curved contact in torques and losses: losses.heathcote_percent says what it would add",
    PARTS,
    INERTIA,
    "ripple: the work of loads that change as balls roll over errors, and enter and leave the loaded track",
    "torques of a second, jammed state of a ball, which may exist at high coefficients of friction (seen from 0.3 on)",
)
#: What an instant leaves out besides, by whether friction feeds back and whether neighbours push.
BESIDES = {
    (False, False): ("friction that moves a ball across its grooves", "contact between balls at the scene's instant"),
    (True, False): ("contact between balls at the scene's instant",),
    (False, True): (
        "friction, and forces between balls, that move a ball across its grooves",
        "forces between balls in the balance of contact loads",
    ),
    (True, True): (
        "forces between balls, and what they change of friction, that move a ball across its grooves",
        "forces between balls in the balance of contact loads",
    ),
}

#: What every kind leaves out.
_KINDS = (
    LUBRICANT,
    HYSTERESIS,
    "Heathcote slip over the curved contact, which counts where contacts are wide or contact angles small",
    PARTS,
    INERTIA,
    "yielding: contacts are elastic at every pressure",
    "elastic bodies: screw, shaft, nut and rings are rigid but for Hertz's contacts",
)
_LOADS_GIVEN = "friction in the balance of loads: the contacts carry what they carry without it"
_FEW = "the other balls of the track, and how all of them share the load"
_INSTANT = "time: one instant, whose ball motions are steady"
_JAMMED = "a second, jammed state of a ball, which may exist at high coefficients of friction"
#: What a screw leaves out besides, by the word of its coupling.
_COUPLING = {
    "none": (_LOADS_GIVEN,),
    "ball": ("friction in the balance of loads on the screw: it moves the balls only",),
    "ball and screw": (),
}
_OF_KIND = {
    "bearing ball": (_LOADS_GIVEN, _FEW, _INSTANT, "tilt of the rings"),
    "bearing pair": (
        _LOADS_GIVEN,
        "contact between balls",
        "time: one position of the balls at every load angle",
        "geometric errors but for clearance",
    ),
    "linear pair": (_LOADS_GIVEN, _FEW, _INSTANT),
    "linear chain": (_LOADS_GIVEN, "the ends of the loaded zone and the return: balls that enter and leave", _INSTANT),
    "screw pair": (_FEW, _INSTANT, _JAMMED),
    "screw run": (
        "geometric errors but for the deviations of contact angles and the oversize that the scene gives",
        "run-in of the grooves, and balls in the return: they roll along without load",
        "inertia of the balls: every instant is steady",
        _JAMMED,
    ),
}


def left_out_of_kind(kind: str, coupling: str | None = None) -> list[str]:
    """Effects that the result of a scene of a kind leaves out; coupling: of friction to loads, of a screw."""
    return [*_OF_KIND[kind], *(_COUPLING[coupling] if coupling else ()), *_KINDS]

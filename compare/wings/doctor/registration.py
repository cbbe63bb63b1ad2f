"""What the wing of checks of the machine adds."""

from rollbench.compare.registration import Registration

REGISTRATION = Registration(commands={"doctor": "wings.doctor.arguments"})

"""What the wing of random errors adds: chains that a source is computed by, and nothing of its own."""

from rollbench.compare.registration import Registration

REGISTRATION = Registration(folders=("lowfi/random_errors",))

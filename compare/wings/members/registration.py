"""What the wing of members adds."""

from rollbench.comparison.registration import Registration

REGISTRATION = Registration(functions={"members": "wings.members.command:run"})

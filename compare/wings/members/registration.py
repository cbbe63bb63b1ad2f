"""What the wing of members adds."""

from rollbench.compare.registration import Registration

REGISTRATION = Registration(functions={"members": "wings.members.command:run", "ensemble": "wings.members.command:library"})

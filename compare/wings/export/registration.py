"""What the wing of exports to other programs adds."""

from rollbench.compare.registration import Registration

REGISTRATION = Registration(folders=("meshes/exchange",), commands={"export": "wings.export.arguments"})

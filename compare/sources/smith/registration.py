"""What Smith (1994) adds."""

from rollbench.compare.registration import Part, Registration

REGISTRATION = Registration(
    title="Smith (1994)", needs=("bearings", "evidence"), parts=(Part("smith", "sources.smith.section", page="sources"),)
)

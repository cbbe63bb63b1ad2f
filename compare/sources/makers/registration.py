"""What makers' tables add."""

from rollbench.compare.registration import Part, Registration

REGISTRATION = Registration(
    needs=("bearings", "evidence", "friction"),
    parts=(Part("outside", "sources.makers.section", page="outside"),),
    functions={"outside": "sources.makers.section:first_page"},
)

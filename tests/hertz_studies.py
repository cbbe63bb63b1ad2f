"""Studies of Hertz's contacts on blocks, shared by the tests of one group: each is made once."""

from functools import cache

from rollbench.hifi.contact import block

GROUP = "Hertz blocks"
study = cache(block.solve_hertz_contact)

"""The kernels of chains of balls in two engines from one source, by the scheme of ``lowfi.jit``."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Literal

from lowfi import jit
from lowfi.friction import chain_kernels

Engine = Literal["interpreted", "compiled"]


def engine(name: Engine) -> ModuleType:
    """The kernels as plain Python or compiled by numba."""
    return _compiled() if name == "compiled" else chain_kernels


@cache
def _compiled() -> ModuleType:
    """The kernels' folder loaded a second time under a name whose functions ``lowfi.jit.kernel`` compiles."""
    return jit.load_compiled(f"{jit.COMPILED}_chain", Path(__file__).parent / "chain_kernels")

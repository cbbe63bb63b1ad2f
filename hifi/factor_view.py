"""The supernodes of a Cholesky factor where CHOLMOD keeps them.

cvxopt hands factors out only whole and numeric. Its factors are capsules around CHOLMOD's own record (cholmod_factor_struct
of SuiteSparse, the same from version 1 to 7), which is read here. What does not look like that record is refused.
"""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np

from meshes.arrays import Index

_SIZES = ("nsuper", "ssize", "xsize", "maxcsize", "maxesize")
_FLAGS = ("ordering", "is_ll", "is_super", "is_monotonic", "itype", "xtype", "dtype", "useGPU")


class _Factor(ctypes.Structure):
    """cholmod_factor_struct."""

    _fields_ = (
        ("n", ctypes.c_size_t),
        ("minor", ctypes.c_size_t),
        *((name, ctypes.c_void_p) for name in ("Perm", "ColCount", "IPerm")),
        ("nzmax", ctypes.c_size_t),
        *((name, ctypes.c_void_p) for name in ("p", "i", "x", "z", "nz", "next", "prev")),
        *((name, ctypes.c_size_t) for name in _SIZES),
        *((name, ctypes.c_void_p) for name in ("super", "pi", "px", "s")),
        *((name, ctypes.c_int) for name in _FLAGS),
    )


def structure(factor: Any, size: int) -> tuple[Index, Index, Index, Index] | None:
    """Order, first columns, starts of rows, and rows of the supernodes of a symbolic or numeric factor of ``size`` rows, as
    arrays of integers; None where the record is not as expected."""
    name = _capsule("PyCapsule_GetName", ctypes.c_char_p)(factor)
    if name is None or not name.startswith(b"CHOLMOD FACTOR"):
        return None
    get = ctypes.pythonapi.PyCapsule_GetPointer
    get.restype, get.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    record = _Factor.from_address(get(factor, name))
    if not (record.n == size and record.is_super == 1 and record.itype in (0, 2) and record.s and record.Perm):
        return None
    integer = ctypes.c_int64 if record.itype == 2 else ctypes.c_int32
    parts = (
        (record.Perm, size),
        (record.super, record.nsuper + 1),
        (record.pi, record.nsuper + 1),
        (record.s, record.ssize),
    )
    order, first, start, rows = (np.array(_view(at, count, integer), dtype=np.int64) for at, count in parts)
    whole = first[0] == start[0] == 0 and first[-1] == size and start[-1] == rows.size
    return (order, first, start, rows) if whole else None


def _capsule(name: str, result: Any) -> Any:
    found = getattr(ctypes.pythonapi, name)
    found.restype, found.argtypes = result, [ctypes.py_object]
    return found


def _view(address: int, count: int, kind: Any) -> Any:
    return np.ctypeslib.as_array(ctypes.cast(address, ctypes.POINTER(kind)), (count,))

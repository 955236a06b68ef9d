"""How kernels are compiled: cached, without fast-math, with IEEE division (a check for zero would keep loops from vectorising),
and without reference counts.

A kernel only works in arrays it is given. Telling numba so (``_nrt=False``) makes row slices free; counted, they cost a fifth
of a frame.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit

__all__ = ["inlined", "kernel"]


def kernel(function: Callable[..., Any]) -> Any:
    """Compile a function that allocates nothing."""
    return njit(cache=True, fastmath=False, error_model="numpy", _nrt=False)(function)


def inlined(function: Callable[..., Any]) -> Any:
    """Compile a small function into each of its callers' loops."""
    return njit(cache=True, fastmath=False, error_model="numpy", inline="always")(function)

"""How kernels are compiled: without fast-math but for products fused into sums (one rounding, not two: a twentieth of a frame),
with IEEE division (a check for zero would keep loops from vectorising), and without reference counts. ``exact`` kernels follow
somebody's rule bit for bit and fuse nothing.

A kernel only works in arrays it is given. Telling numba so (``_nrt=False``) makes row slices free; counted, they cost a fifth
of a frame.

Fortran's rule holds for kernels: memory that one writes is reached by one of its arguments alone. Believing it, the compiler need
not find out with every row whether ten planes overlap, nor give up vectors where it cannot: a tenth of a frame. So loops take
rows, not the planes or the work space they are rows of. A test runs all kernels in Python and watches the rule. Entries do without
it: what Python gives them is the caller's matter.

Three things make a first start short. Only what Python calls gets the code that unpacks Python's arguments, and a place in the
cache: most kernels are called by others and are compiled into them. A kernel is compiled once per type of its arguments, where
numba takes the literal 3 for a type of its own: pass ``INT(3)``, and let counters start from ``INT(0)``. And arrays are copied by
loops: numba needs seconds for the general case behind ``a[:] = b``.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import njit

from pedcross_env.camera.kernels.compiling import EntryCompiler, KernelCompiler, follow_all_kernels

__all__ = [
    "BOOL",
    "INT",
    "LANES",
    "allocating",
    "allocating_kernel",
    "entry",
    "exact_entry",
    "exact_inlined",
    "exact_kernel",
    "inlined",
    "kernel",
]

INT = np.int64
"""Makes an integer of one type of a literal."""
BOOL = np.bool_
"""The same for True and False, which numba takes for types of their own too."""
LANES = 8
"""Of a vector of 32-bit numbers. What is left over when a loop does not end on a whole vector is done one by one: short rows are
worked on in whole vectors where what lies beside them does not matter."""


_FUSED = {"contract"}


def entry(function: Callable[..., Any]) -> Any:
    """Compile a function that allocates nothing and that Python may call; cached."""
    return _entry(function, _FUSED)


def exact_entry(function: Callable[..., Any]) -> Any:
    """Compile like ``entry``, every product and sum rounded as written."""
    return _entry(function, False)


def allocating(function: Callable[..., Any]) -> Any:
    """Compile a function that allocates and that Python may call; cached."""
    return _entry(function, _FUSED, allocates=True)


def allocating_kernel(function: Callable[..., Any]) -> Any:
    """Compile a function that allocates or reshapes into the ``allocating`` entries that call it."""
    return _kernel(function, _FUSED, allocates=True)


def kernel(function: Callable[..., Any]) -> Any:
    """Compile a function that allocates nothing into the entries that call it; a call from Python is a TypeError."""
    return _kernel(function, _FUSED)


def exact_kernel(function: Callable[..., Any]) -> Any:
    """Compile like ``kernel``, every product and sum rounded as written."""
    return _kernel(function, False)


def inlined(function: Callable[..., Any]) -> Any:
    """Compile like ``kernel`` into each place that calls it, however long it is.

    For what is called per pixel, and for loops over short rows: a call hands over seven numbers for each row, through memory.
    """
    return _kernel(function, _FUSED, forceinline=True)


def exact_inlined(function: Callable[..., Any]) -> Any:
    """Compile like ``inlined``, every product and sum rounded as written."""
    return _kernel(function, False, forceinline=True)


def _entry(function: Callable[..., Any], fused: Any, *, allocates: bool = False) -> Any:
    dispatcher = _compiled(function, fused, allocates, cache=True, pipeline_class=EntryCompiler)
    return follow_all_kernels(dispatcher)


def _kernel(
    function: Callable[..., Any], fused: Any, *, allocates: bool = False, forceinline: bool = False
) -> Any:
    dispatcher = _compiled(
        function, fused, allocates, forceinline=forceinline, pipeline_class=KernelCompiler,
        no_cpython_wrapper=True, no_cfunc_wrapper=True,
    )  # fmt: skip

    def refuse(*args: Any, **kwargs: Any) -> None:
        raise TypeError(
            f"{function.__module__}.{function.__name__} is compiled for other kernels to call and was called from Python: "
            "decorate it with entry instead of kernel."
        )

    # Python finds no compiled version and asks for one here
    dispatcher._insert = lambda *args, **kwargs: None
    dispatcher._compile_for_args = refuse
    return dispatcher


def _compiled(function: Callable[..., Any], fused: Any, allocates: bool, **options: Any) -> Any:
    counted = {} if allocates else {"_nrt": False}
    return njit(error_model="numpy", fastmath=fused, **counted, **options)(function)

"""numba's compiler without work that kernels do not need: a first start without a cache takes 33 s, not 58.

The code that comes out is numba's own; only what is done twice or thrown away is left out. And its cache, told what else a cached
function depends on.
"""

from __future__ import annotations

import gc
import logging
from collections.abc import Callable
from functools import lru_cache
from typing import Any

from numba.core import config
from numba.core.codegen import JITCodeLibrary, ll
from numba.core.compiler import Compiler, Flags

from pedcross_env.source import source_digest
from pedcross_env.warmup import COMPILING

__all__ = ["EntryCompiler", "KernelCompiler", "follow_all_kernels"]

_LARGE_FRAME_WORDS = 1 << 16
_FULL_COLLECTION_EVERY = 50
_KERNELS = (b"njit", b"kernels.jit")  # what files with kernels hold


@lru_cache(maxsize=1)
def _announce() -> None:
    """Log once per process why the first picture takes its time."""
    logging.getLogger("pedcross_env").warning(COMPILING)


def follow_all_kernels(dispatcher: Any) -> Any:
    """Let what is cached of a function go stale when any kernel changes, and return the function.

    What a function calls is compiled into it, but numba looks at the function's own file alone.
    """
    index = dispatcher._cache._cache_file
    index._source_stamp = (index._source_stamp, source_digest(holding=_KERNELS))
    return dispatcher


class _Flags(Flags):
    """Compares what was set; numba's own builds two dicts of all options, and does so half a million times."""

    __slots__ = ()

    def __hash__(self) -> int:
        return hash(_Flags)

    def __eq__(self, other: object) -> bool:
        return self is other or (isinstance(other, _Flags) and self._values == other._values)


class _NoEngine:
    """Stands where machine code would be loaded."""

    def set_env(self, name: str, env: object) -> None:
        """Do nothing: an entry has an environment of its own."""


class _Library(JITCodeLibrary):
    """Code that is optimised once, as a whole, when all that it calls is linked in."""

    def _optimize_functions(self, ll_module: Any) -> None:
        """Tidy up functions; numba puts them, and declarations of others, through all there is, here and as a whole."""
        ll_module.data_layout = self._codegen._data_layout
        for function in ll_module.functions:
            if not function.is_declaration:
                passes, builder = self._codegen._function_pass_manager(opt=1)
                passes.run(function, builder)

    def _optimize_final_module(self) -> None:
        """Optimise; numba does so twice, for the sake of reference counts that kernels have none of.

        Loops take one vector at a time, not the usual four: most rows are shorter.
        """
        options = ll.create_pipeline_tuning_options(speed_level=int(config.OPT))
        options.loop_vectorization, options.slp_vectorization = config.LOOP_VECTORIZE, config.SLP_VECTORIZE
        options.loop_interleaving = False
        builder = ll.create_pass_builder(self._codegen._tm, options)
        passes = builder.getModulePassManager()
        passes.add_refprune_pass()
        passes.run(self._final_module, builder)


class _LinkedLibrary(_Library):
    """Code that is only linked into that of others, which is then optimised and made machine code as a whole."""

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True

    @property
    def codegen(self) -> Any:
        """What its machine code would be given to."""
        return _NoEngine()

    def get_pointer_to_function(self, name: str) -> int:
        """None (0): there is no machine code."""
        self._ensure_finalized()
        return 0


def _on_large_frame(work: Callable[[], Any]) -> Any:
    return work()


# Python takes memory for its frames in pieces of 16 KiB and gives a piece back as soon as its last frame is left: a loop of calls
# that happens to begin where a piece ends takes and gives one back with every call. That was a sixth of the time. A frame that
# needs more than a piece gets a large one, in which there is room for all frames above it.
_on_large_frame.__code__ = _on_large_frame.__code__.replace(co_stacksize=_LARGE_FRAME_WORDS + 1)


class EntryCompiler(Compiler):
    """Compiles what Python calls."""

    def __init__(
        self,
        typingctx: Any,
        targetctx: Any,
        library: Any,
        args: Any,
        return_type: Any,
        flags: Flags,
        locals: Any,
    ) -> None:
        super().__init__(typingctx, targetctx, library, args, return_type, _Flags(flags), locals)

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        """Compile a Python function."""
        _announce()
        if self.state.library is None:
            self.state.library = _Library(self.state.targetctx.codegen(), func.__qualname__)
            self.state.library.enable_object_caching()
        usual = gc.get_threshold()
        # what has been compiled stays: looking through it again and again was a tenth of the time
        gc.set_threshold(*usual[:2], max(usual[2], _FULL_COLLECTION_EVERY))
        try:
            return _on_large_frame(lambda: super(EntryCompiler, self).compile_extra(func))
        finally:
            gc.set_threshold(*usual)


class KernelCompiler(EntryCompiler):
    """Compiles what other kernels call."""

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        """Compile a Python function."""
        self.state.flags.noalias = not self.state.flags.nrt  # counts of references are reached by many ways
        self.state.library = _LinkedLibrary(self.state.targetctx.codegen(), func.__qualname__)
        return super().compile_extra(func)

"""The compiler without needless work: the same numbers, one notice, and everything put back."""

import gc
import logging
import math

import numpy as np
import pytest
from numba import njit
from numba.core.compiler import Flags

from pedcross_env.camera.kernels import compiling
from pedcross_env.camera.kernels.jit import entry, exact_kernel, kernel


def _row_sum(row):
    total = 0.0
    for x in range(row.size):
        total += math.sqrt(row[x]) / (x + 1.0)
    return total


def _fill(values, out):
    for y in range(values.shape[0]):
        out[y] = _sum(values[y])


def _filled(values):
    out = np.empty(values.shape[0])
    for y in range(values.shape[0]):
        out[y] = _sum(values[y])
    return out


_sum = exact_kernel(_row_sum)


def _entry(function):
    """As jit.entry, without a cache: what is compiled here is compiled every time."""
    return njit(error_model="numpy", _nrt=False, pipeline_class=compiling.EntryCompiler)(function)


def test_what_kernels_compute_is_what_numba_and_python_compute_bit_for_bit():
    values = np.random.default_rng(3).random((5, 37))
    out = np.empty(5)
    _entry(_fill)(values, out)
    own = njit(error_model="numpy")(_row_sum)
    np.testing.assert_array_equal(out, [own(row) for row in values])
    np.testing.assert_array_equal(out, [_row_sum(row) for row in values])
    np.testing.assert_array_equal(
        njit(error_model="numpy", pipeline_class=compiling.EntryCompiler)(_filled)(values), out
    )


def test_a_kernel_is_compiled_without_machine_code_of_its_own():
    _entry(_fill)(np.ones((2, 3)), np.empty(2))
    assert _sum.overloads
    for compiled in _sum.overloads.values():
        assert compiled.library.get_pointer_to_function(compiled.fndesc.mangled_name) == 0
    with pytest.raises(TypeError, match="decorate it with entry"):
        _sum(np.ones(3))


def test_the_first_compilation_of_a_process_is_announced_and_no_other(caplog):
    compiling._announce.cache_clear()
    with caplog.at_level(logging.WARNING, logger="pedcross_env"):
        _entry(_fill)(np.ones((2, 3)), np.empty(2))
        _entry(_fill)(np.ones((2, 3), np.float32), np.empty(2, np.float32))
    assert [record.getMessage() for record in caplog.records] == [compiling.COMPILING]


def test_garbage_is_collected_as_before_after_compiling_even_if_that_fails():
    before = gc.get_threshold()
    _entry(_fill)(np.ones((2, 3)), np.empty(2))
    assert gc.get_threshold() == before
    with pytest.raises(Exception, match="shape"):
        _entry(_fill)(1.0, 2.0)
    assert gc.get_threshold() == before


def test_settings_are_equal_if_what_was_set_is():
    one, same, other = Flags(), Flags(), Flags()
    one.nrt = same.nrt = True
    other.nrt = False
    quick = [compiling._Flags(flags) for flags in (one, same, other)]
    assert quick[0] == quick[1]
    assert hash(quick[0]) == hash(quick[1])
    assert quick[0] != quick[2]
    assert quick[0].copy() == quick[0]


def _doubled(values):
    for i in range(values.shape[0]):
        values[i] *= 2.0


def test_what_is_cached_goes_stale_with_any_kernel(monkeypatch):
    """A kernel that changes is compiled into others, whose own files stay as they are."""

    def cached() -> bool:
        dispatcher = entry(_doubled)
        dispatcher(np.ones(3))
        return sum(dispatcher.stats.cache_hits.values()) == 1

    cached()
    assert cached()
    monkeypatch.setattr(compiling, "source_digest", lambda holding: "other sources")
    assert not cached()
    assert cached()


def _square_and_add(a, b, out):
    out[0] = a * a + b


def test_products_are_fused_into_sums_in_kernels_and_not_in_exact_ones():
    a, b = 1.0 + 2.0**-30, -1.0 - 2.0**-29
    found = {}
    for decorate in (kernel, exact_kernel):
        out = np.empty(1)
        njit(error_model="numpy", pipeline_class=compiling.EntryCompiler)(
            _calling(decorate(_square_and_add))
        )(a, b, out)
        found[decorate] = out[0]
    assert found[exact_kernel] == 0.0  # a squared, rounded, is 1 + 2**-29
    assert found[kernel] in (
        0.0,
        2.0**-60,
    )  # with fused operations, where the processor has them, it is exact


def _calling(inner):
    def call(a, b, out):
        inner(a, b, out)

    return call

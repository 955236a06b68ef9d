"""How kernels are compiled."""

from __future__ import annotations

import pytest

from pedcross_env.camera.kernels.jit import entry, kernel


@kernel
def _twice(x):
    return 2 * x


@entry
def _four_times(x):
    return _twice(_twice(x))


def test_a_kernel_is_compiled_into_the_entry_that_calls_it():
    assert _four_times(3.0) == 12.0


def test_calling_a_kernel_from_python_says_what_to_do():
    _four_times(3.0)  # compiled by now, but not for Python
    with pytest.raises(TypeError, match=r"_twice .*decorate it with entry"):
        _twice(3.0)

"""What kernels are compiled to rely on: memory that one writes is reached by one of its arguments alone."""

import json
import subprocess
import sys
from pathlib import Path

import kernels_in_python
import numpy as np

SCRIPT = Path(kernels_in_python.__file__)


def test_no_kernel_is_given_memory_that_it_writes_by_two_ways():
    run = subprocess.run([sys.executable, str(SCRIPT)], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    found = json.loads(run.stdout.splitlines()[-1])
    assert found["shared"] == []
    assert found["never called"] == []


def _add(a, b):
    b[0] += a[0]


def test_shared_memory_is_seen_where_it_is_written_and_only_there():
    memory = np.ones(8)
    for a, b in ((memory[:4], memory[4:]), (memory[::2], memory[1::2])):
        kernels_in_python.watched(_add)(a, b)
    kernels_in_python.watched(lambda pair, out: None)((memory, memory[2:]), memory)
    assert kernels_in_python.shared == set()
    kernels_in_python.watched(_add)(memory[:4], memory[3:])
    assert [(first, second) for _, first, second in kernels_in_python.shared] == [("a", "b")]
    kernels_in_python.watched(lambda pair, out: _add(pair[0], out))((memory[:2], memory[4:]), memory[1:3])
    assert {(first, second) for _, first, second in kernels_in_python.shared} == {
        ("a", "b"),
        ("pair[0]", "out"),
    }

"""The machine that a benchmark runs on, as its first line names it, and its clock of CPU time."""

from __future__ import annotations

import os
import platform
import time
from pathlib import Path

__all__ = ["cpu_name", "cpu_s"]


def cpu_name() -> str:
    """The processor's own name where the system tells it, its CPUs and its widest vectors."""
    path = Path("/proc/cpuinfo")
    lines = path.read_text().splitlines() if path.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    flags = next((line for line in lines if line.startswith("flags")), "")
    widest = next((name for name in ("avx512f", "avx2", "avx") if f" {name} " in f"{flags} "), "")
    return f"{names[0] if names else platform.processor()} ({os.cpu_count()} CPUs, {widest or platform.machine()})"


def cpu_s() -> float:
    """CPU seconds of this process, the system's for it included: exact to a microsecond."""
    return time.process_time()

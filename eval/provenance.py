"""What a result was made with: versions, machine, command."""

from __future__ import annotations

import os
import platform
import shlex
import sys
import time
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from pedcross_env import __version__
from pedcross_env.source import source_digest

__all__ = ["machine", "provenance"]

SOURCE = ("pedcross_env", "perception", "agents", "eval")
PACKAGES = ("numpy", "numba", "torch", "spikingjelly", "gymnasium", "highway-env", "opencv-python-headless")


def provenance() -> dict[str, Any]:
    """Return versions and a digest of the source, the machine, the command line of this process and the time (UTC)."""
    versions = {
        "pedcross": f"{__version__}, source {source_digest(*SOURCE)}",
        "python": platform.python_version(),
    }
    for package in PACKAGES:
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            versions[package] = "not installed"
    command = shlex.join([Path(sys.argv[0]).name, *sys.argv[1:]])
    return {
        "versions": versions,
        "machine": machine(),
        "command": command,
        "time_utc": time.strftime("%Y-%m-%d %H:%M", time.gmtime()),
    }


def machine() -> dict[str, Any]:
    """Return the processor's name, the number of cores this process may use, and the system."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return {"cpu": _cpu_name(), "cores": cores, "system": f"{platform.system()} {platform.machine()}"}


def _cpu_name() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass  # not Linux: the platform's own name is all there is
    return platform.processor() or platform.machine()

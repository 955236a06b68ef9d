"""Which code made a result: a version's number stays while the code beneath it changes."""

from __future__ import annotations

import hashlib
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path

__all__ = ["source_digest"]


@lru_cache
def source_digest(*packages: str, holding: tuple[bytes, ...] = (b"",)) -> str:
    """Return 16 hex digits of the Python source of packages, found but not imported.

    Args:
        packages: Names of top level packages; none: the simulator, ``pedcross_env``.
        holding: Only files that hold one of these count.
    """
    digest = hashlib.sha256()
    for package in packages or ("pedcross_env",):
        spec = find_spec(package)
        if spec is None or not spec.submodule_search_locations:
            raise ModuleNotFoundError(f"{package!r} is no package that can be found.")
        folder = Path(spec.submodule_search_locations[0])
        for path in sorted(folder.rglob("*.py")):
            content = path.read_bytes()
            if not any(part in content for part in holding):
                continue
            digest.update(f"{package}/{path.relative_to(folder).as_posix()} {len(content)}\n".encode())
            digest.update(content)
    return digest.hexdigest()[:16]

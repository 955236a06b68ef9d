"""Which detectors are meant: names of shipped checkpoints, or paths of others."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from agents import CONTROLS
from pedcross_env.errors import ConfigError, unknown_name

__all__ = ["DetectorSpec", "load_detector", "resolve_detectors"]


@dataclass(frozen=True, slots=True, kw_only=True)
class DetectorSpec:
    """What is known of a detector before its network is loaded.

    Attributes:
        name: For tables, unique in a run.
        path: The checkpoint's folder, what a loader gets.
        modality: "rgb" or "dvs".
        threshold: p from which on it says "crossing"; chosen on validation clips by training.
        fingerprint: Of its weights and settings.
        test_videos: "<subset>/<video>" that its training kept apart; None where unknown.
        about: The checkpoint's own description, for the report.
    """

    name: str
    path: str
    modality: str
    threshold: float
    fingerprint: str
    test_videos: tuple[str, ...] | None = None
    about: dict[str, Any] = field(default_factory=dict)


def load_detector(path: str) -> Any:
    """Load a checkpoint; torch is imported here and not before."""
    from perception.checkpoint import load_detector as load

    return load(path)


def resolve_detectors(names: Sequence[str]) -> list[DetectorSpec]:
    """Describe the named detectors, or all shipped ones for no names.

    Args:
        names: Names of shipped checkpoints, or folders.

    Raises:
        ConfigError: For a name that is neither, or one that two of them share.
        DataError: For a damaged checkpoint.
    """
    from perception.checkpoint import list_shipped

    shipped = list_shipped()
    folders = []
    for name in names or shipped:
        if name in shipped:
            folders.append(Path(shipped[name]))
        elif Path(name).is_dir():
            folders.append(Path(name))
        else:
            error = unknown_name("detector", name, shipped)
            raise ConfigError(f"{error} Or give the folder of a checkpoint.")
    if not folders:
        raise ConfigError("no detectors: none is shipped and none is named; train one or give its folder.")
    specs = [_describe(folder) for folder in folders]
    taken: set[str] = set(CONTROLS)
    for spec in specs:
        if spec.name in taken:
            raise ConfigError(
                f"two detectors are called {spec.name!r}; change 'name' in {spec.path}/config.json."
            )
        taken.add(spec.name)
    return specs


def _describe(folder: Path) -> DetectorSpec:
    from perception.checkpoint import read_config

    config = read_config(folder)
    digest = hashlib.sha256()
    files = sorted(path for path in folder.iterdir() if path.suffix in (".safetensors", ".json"))
    for path in files:
        digest.update(path.read_bytes())
    about = dataclasses.asdict(config)
    splits = about.pop("splits")
    test = splits.get("test")
    about["size_bytes"] = sum(path.stat().st_size for path in files)
    return DetectorSpec(
        name=config.name,
        path=str(folder),
        modality=config.modality,
        threshold=config.threshold,
        fingerprint=digest.hexdigest()[:16],
        test_videos=None if test is None else tuple(test),
        about=about,
    )

"""Which detectors are meant: shipped checkpoints, folders of others, or "module:factory" of a user's own."""

from __future__ import annotations

import dataclasses
import hashlib
import importlib
import sys
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
        path: The checkpoint's folder, or "module:factory"; what a loader gets.
        modality: "rgb" or "dvs".
        threshold: p from which on it says "crossing"; chosen on validation clips by training.
        braking_threshold: p from which on the car brakes; chosen there for few false alarms.
        fingerprint: Of its weights and settings.
        test_videos: "<subset>/<video>" that its training kept apart; None where unknown.
        about: The checkpoint's own description, for the report.
    """

    name: str
    path: str
    modality: str
    threshold: float
    braking_threshold: float
    fingerprint: str
    test_videos: tuple[str, ...] | None = None
    about: dict[str, Any] = field(default_factory=dict)


def load_detector(path: str) -> Any:
    """Load a checkpoint, or call a factory; torch is imported here and not before."""
    if _is_factory(path):
        return _call_factory(path)
    from perception.checkpoint import load_detector as load

    return load(path)


def resolve_detectors(names: Sequence[str]) -> list[DetectorSpec]:
    """Describe the named detectors, or all shipped ones for no names.

    Args:
        names: Names of shipped checkpoints, folders, or "module:factory", where the factory takes nothing
            and returns a perception.detector.Detector; its ``threshold`` and ``braking_threshold``,
            where it has them, replace 0.5.

    Raises:
        ConfigError: For a name that is neither, or one that two of them share.
        DataError: For a damaged checkpoint.
    """
    from perception.checkpoint import list_shipped

    shipped = list_shipped()
    specs = []
    for name in names or shipped:
        if name in shipped:
            specs.append(_describe(Path(shipped[name])))
        elif Path(name).is_dir():
            specs.append(_describe(Path(name)))
        elif _is_factory(name):
            specs.append(_describe_factory(name))
        else:
            error = unknown_name("detector", name, shipped)
            raise ConfigError(f"{error} Or give the folder of a checkpoint, or 'module:factory'.")
    if not specs:
        raise ConfigError("no detectors: none is shipped and none is named; train one or give its folder.")
    taken: set[str] = set(CONTROLS)
    for spec in specs:
        if spec.name in taken:
            raise ConfigError(
                f"two detectors are called {spec.name!r}; change 'name' in {spec.path}/config.json."
            )
        taken.add(spec.name)
    return specs


def _is_factory(name: str) -> bool:
    return name.count(":") == 1 and not Path(name).exists()


def _call_factory(name: str) -> Any:
    """Import "module:factory", the working directory included, and check what it builds."""
    from perception.detector import Detector

    module, factory = name.split(":")
    if "" not in sys.path and str(Path.cwd()) not in sys.path:
        sys.path.insert(0, str(Path.cwd()))
    try:
        detector = getattr(importlib.import_module(module), factory)()
    except (ImportError, AttributeError) as error:
        raise ConfigError(
            f"detector {name!r} cannot be loaded ({error}); give 'module:factory' of an importable module."
        ) from error
    if not isinstance(detector, Detector):
        raise ConfigError(
            f"detector {name!r} is a {type(detector).__name__} without all of name, modality, frames, reset, "
            "update and predict; see perception.contract.check_detector."
        )
    return detector


def _describe_factory(name: str) -> DetectorSpec:
    detector = _call_factory(name)
    source = getattr(sys.modules[name.split(":")[0]], "__file__", None)
    content = Path(source).read_bytes() if source else name.encode()
    return DetectorSpec(
        name=detector.name,
        path=name,
        modality=detector.modality,
        threshold=float(getattr(detector, "threshold", 0.5)),
        braking_threshold=float(getattr(detector, "braking_threshold", getattr(detector, "threshold", 0.5))),
        fingerprint=hashlib.sha256(content).hexdigest()[:16],
    )


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
        braking_threshold=config.braking_threshold,
        fingerprint=digest.hexdigest()[:16],
        test_videos=None if test is None else tuple(test),
        about=about,
    )

"""Named settings, some of their fields changed."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, TypeVar

from pedcross_env.errors import unknown_name

__all__ = ["changed_preset"]

Settings = TypeVar("Settings")


def changed_preset(
    what: str, presets: Mapping[str, Settings], name: str, changes: Mapping[str, Any]
) -> Settings:
    """Return a preset with some fields changed.

    Args:
        what: How errors call the preset.
        presets: Frozen dataclasses of one class, by name.
        name: One of them.
        changes: Values by field.

    Raises:
        ConfigError: For an unknown name or field, naming the nearest one; and whatever the class refuses.
    """
    if name not in presets:
        raise unknown_name(what, name, presets)
    preset: Any = presets[name]
    known = [f.name for f in dataclasses.fields(preset)]
    for key in changes:
        if key not in known:
            raise unknown_name(f"key for {type(preset).__name__}", key, known)
    changed: Settings = dataclasses.replace(preset, **changes)
    return changed

"""Errors that say what was given, what is allowed and what to do."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

__all__ = ["PedcrossError", "ConfigError", "DataError", "nearest", "require", "unknown_name"]


class PedcrossError(Exception):
    """Base of all errors a user can mend; the command line prints its text without a stack trace."""


class ConfigError(PedcrossError, ValueError):
    """A setting that is unknown, out of range or contradicts another."""


class DataError(PedcrossError):
    """A file that is missing, damaged or not what its name says."""


def require(condition: bool, name: str, value: object, allowed: str) -> None:
    """Raise ConfigError naming the setting, its value and what is allowed, unless ``condition`` holds."""
    if not condition:
        raise ConfigError(f"{name} = {value!r} is not allowed: it must be {allowed}.")


def nearest(name: str, allowed: Iterable[str]) -> str | None:
    """Return the allowed name most like ``name``, or None where nothing is similar."""
    matches = difflib.get_close_matches(name.lower(), list(allowed), n=1, cutoff=0.4)
    return matches[0] if matches else None


def unknown_name(what: str, name: object, allowed: Iterable[str]) -> ConfigError:
    """Build the error for an unknown name: names it, the nearest valid one and all that are allowed."""
    names = sorted(allowed)
    match = nearest(str(name), names)
    hint = f" Did you mean {match!r}?" if match else ""
    return ConfigError(f"unknown {what} {name!r}.{hint} Allowed: {', '.join(names)}.")

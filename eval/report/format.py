"""Numbers as text for tables: nan and None are a dash, never a 0."""

from __future__ import annotations

import math
from typing import Any

__all__ = ["DASH", "count", "interval", "kmh", "number", "p_value", "percent", "percent_interval"]

DASH = "–"


def _missing(value: Any) -> bool:
    return value is None or (isinstance(value, float) and math.isnan(value))


def number(value: Any, digits: int = 2) -> str:
    """Return ``value`` with ``digits`` decimals."""
    return DASH if _missing(value) else f"{value:.{digits}f}"


def percent(value: Any, digits: int = 0) -> str:
    """Return a share as per cent."""
    return DASH if _missing(value) else f"{100 * value:.{digits}f} %"


def kmh(speed_mps: Any, digits: int = 0) -> str:
    """Return a speed in km/h, without its unit."""
    return DASH if _missing(speed_mps) else f"{3.6 * speed_mps:.{digits}f}"


def interval(low: Any, high: Any, digits: int = 2) -> str:
    """Return bounds in brackets; empty where they are undefined."""
    return "" if _missing(low) or _missing(high) else f"[{low:.{digits}f}, {high:.{digits}f}]"


def percent_interval(low: Any, high: Any) -> str:
    """Return bounds in per cent in brackets; empty where they are undefined."""
    return "" if _missing(low) or _missing(high) else f"[{100 * low:.0f}, {100 * high:.0f}]"


def p_value(value: Any) -> str:
    """Return a p-value with as many digits as it is worth."""
    if _missing(value):
        return DASH
    return "< 0.001" if value < 0.001 else f"{value:.3f}" if value < 0.1 else f"{value:.2f}"


def count(value: Any) -> str:
    """Return a large count with a unit prefix: 2.1 M, 350 k."""
    if _missing(value):
        return DASH
    for limit, unit in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
        if value >= limit:
            return f"{value / limit:.2f} {unit}"
    return f"{value:g}"

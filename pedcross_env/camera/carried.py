"""What people carry, as capsules on the frames of a posed body; and how their arms are held for it.

All lengths are shares of the body's height.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from pedcross_env.camera.body import FINE, Body, Colour
from pedcross_env.camera.kernels.pose import CHEST, GROUND, HELD, PELVIS

__all__ = ["add_carried"]

RETRO_CLASS_2 = 330.0  # cd/(lx m2) at 12', ISO 20471
RUBBER, METAL, WOOD = (0.02, 0.02, 0.022), (0.30, 0.30, 0.31), (0.12, 0.07, 0.035)


def _backpack(b: Body, colour: Colour) -> None:
    b.add(CHEST, (-0.075, 0.026, -0.050), (-0.082, 0.024, -0.175), 0.038, 0.046, colour)
    b.add(CHEST, (-0.075, -0.026, -0.050), (-0.082, -0.024, -0.175), 0.038, 0.046, colour)
    strap = (
        (-0.050, 0.046, -0.040),
        (-0.012, 0.048, 0.003),
        (0.034, 0.050, -0.020),
        (0.058, 0.056, -0.075),
        (0.055, 0.062, -0.130),
    )
    for side in (1.0, -1.0):
        for (x0, y0, z0), (x1, y1, z1) in pairwise(strap):
            b.add(CHEST, (x0, side * y0, z0), (x1, side * y1, z1), 0.010, 0.010, colour, fine=FINE)


def _handbag(b: Body, colour: Colour) -> None:
    for z in (0.010, -0.028):
        b.add(PELVIS, (0.040, -0.100, z), (-0.050, -0.100, z), 0.022, 0.022, colour)
    b.add(PELVIS, (0.0, -0.100, 0.01), (-0.006, 0.040, 0.0), 0.006, 0.006, colour, to=CHEST)


def _hi_vis(b: Body, girth: float) -> None:
    """Add two bands of retro-reflective tape round a vest (the trunk's colour) and one over each shoulder."""
    g, tape = girth, (0.55, 0.55, 0.56)
    for side in (1.0, -1.0):
        b.add(
            CHEST,
            (0.030, side * 0.048, -0.050),
            (0.038, side * 0.044, -0.10),
            0.026,
            0.025,
            tape,
            retro=RETRO_CLASS_2,
        )
    for z in (-0.118, -0.172):
        for y in (0.036 * g, 0.0, -0.036 * g):
            b.add(CHEST, (0.004, y, z), (0.004, y, z), 0.0625 * g, 0.0625 * g, tape, retro=RETRO_CLASS_2)


def _umbrella(b: Body, colour: Colour, raining: bool) -> None:
    """Add an umbrella: up in the rain (a dome of ribs and cloth), else rolled in the hand."""
    if not raining:
        b.add(HELD, (0.0, 0.0, 0.02), (0.0, 0.0, -0.34), 0.012, 0.020, colour)
        return
    b.add(HELD, (0.0, 0.0, -0.03), (0.0, 0.0, 0.42), 0.006, 0.005, METAL)
    for k in range(20):
        c, s = float(np.cos(k * np.pi / 10)), float(np.sin(k * np.pi / 10))
        b.add(HELD, (0.03 * c, 0.03 * s, 0.405), (0.245 * c, 0.245 * s, 0.31), 0.016, 0.039, colour)


def _stroller(b: Body, colour: Colour) -> None:
    """Add a stroller ahead of the hands: tub, hood, frame and wheels."""
    ahead = 0.30
    for side in (1.0, -1.0):
        y = side * 0.075
        b.add(GROUND, (ahead + 0.06, y, 0.30), (ahead + 0.36, y, 0.26), 0.065, 0.050, colour)
        b.add(GROUND, (ahead + 0.10, y, 0.40), (ahead + 0.08, y, 0.33), 0.085, 0.075, colour)
        b.add(GROUND, (0.24, side * 0.11, 0.535), (ahead + 0.34, side * 0.13, 0.075), 0.009, 0.009, METAL)
        b.add(
            GROUND, (ahead + 0.20, side * 0.13, 0.26), (ahead + 0.02, side * 0.13, 0.075), 0.009, 0.009, METAL
        )
        for x in (ahead + 0.02, ahead + 0.34):
            corners = [
                (x + 0.055 * np.cos(a), side * 0.14, 0.068 + 0.055 * np.sin(a))
                for a in np.arange(5) * 0.4 * np.pi
            ]
            for k in range(5):
                b.add(GROUND, corners[k], corners[(k + 1) % 5], 0.013, 0.013, RUBBER)
    b.add(GROUND, (0.24, 0.11, 0.535), (0.24, -0.11, 0.535), 0.011, 0.011, RUBBER)


def add_carried(
    b: Body, build: np.ndarray, girth: float, carries: str, colour: Colour, raining: bool
) -> None:
    """Add what somebody carries and set its arms to it."""
    left, right = slice(8, 11), slice(11, 14)
    if carries == "backpack":
        _backpack(b, colour)
    elif carries == "handbag":
        _handbag(b, colour)
    elif carries == "hi-vis":
        _hi_vis(b, girth)
    elif carries == "umbrella":
        _umbrella(b, colour, raining)
        build[left] = (0.95, 0.25, 1.95) if raining else (0.6, 0.0, 0.15)
    elif carries == "stroller":
        _stroller(b, colour)
        build[left] = build[right] = 1.0, 0.40, 0.75
    elif carries == "cane":
        b.add(HELD, (0.0, 0.0, 0.01), (0.02, 0.01, -0.40), 0.009, 0.007, WOOD)
        build[left] = 0.75, 0.20, 0.35
    elif carries == "phone":
        b.add(HELD, (0.0, 0.0, 0.02), (0.0, 0.0, -0.02), 0.014, 0.014, RUBBER)
        build[left] = 1.0, 0.30, 1.75

"""What events are put down to: signal or noise, and the thing whose edge, streak or light made them. NumPy alone.

Causes are one int32 per event: the positive id of an actor, a StaticClass, or an EventCause. An event's cause is that
of its pixel between the two renders in which it falls:

1. Leak, shot noise and hot pixels are known to the sensor itself.
2. Else the change of ln(luminance) has up to three parts: the scene's, the precipitation's and the lightning's. The
   cause is the largest part with the sign of the whole.
3. The scene's part belongs to the nearest thing seen in the pixel or beside it, before or after: an edge between two
   things is the nearer one's, and it may cross a pixel that shows more of the other. The ground, which hides nothing
   that stands on it, counts as farther than all but the sky.
"""

from __future__ import annotations

import numpy as np

from pedcross_env.contracts import EventCause, Frame, StaticClass
from pedcross_env.errors import ConfigError

__all__ = ["blame", "edge_owner", "is_noise"]

_FAR_M = np.float32(1e9)
_NOISE_FROM = EventCause.LEAK  # and below


def is_noise(causes: np.ndarray) -> np.ndarray:
    """Which of the causes are noise of the sensor.

    Args:
        causes: (N,) int32 of ``step_labelled`` or ``info["event_causes"]``.

    Returns:
        (N,) bool.
    """
    return causes <= _NOISE_FROM


def edge_owner(before: Frame, after: Frame) -> np.ndarray:
    """Which thing the scene's changes at each pixel belong to, by rule 3 above.

    Args:
        before: Full render (depth and instance ids) at the start.
        after: At the end.

    Returns:
        (H, W) int32, ids of actors or StaticClass.

    Raises:
        ConfigError: For renders without depth and ids.
    """
    owner, nearest = np.empty(0, np.int32), np.empty(0, np.float32)
    for frame in (after, before):
        ids, depth = frame.instance, frame.depth
        if ids is None or depth is None:
            raise ConfigError("the frame has no depth and ids: render the full frame, not luminance only.")
        order = np.where(ids == StaticClass.GROUND, _FAR_M, depth)
        if not owner.size:
            owner, nearest = ids.astype(np.int32), order.astype(np.float32)
        for here, beside in _SHIFTS:
            closer = order[beside] < nearest[here]
            nearest[here] = np.where(closer, order[beside], nearest[here])
            owner[here] = np.where(closer, ids[beside], owner[here])
    return owner


_ALL, _FIRST, _LAST = slice(None), slice(None, -1), slice(1, None)
_SHIFTS = (
    ((_ALL, _ALL), (_ALL, _ALL)),
    ((_FIRST, _ALL), (_LAST, _ALL)),
    ((_LAST, _ALL), (_FIRST, _ALL)),
    ((_ALL, _FIRST), (_ALL, _LAST)),
    ((_ALL, _LAST), (_ALL, _FIRST)),
)


def blame(
    owner: np.ndarray, *, scene: np.ndarray, precipitation: np.ndarray, lightning: np.ndarray
) -> np.ndarray:
    """Put each pixel's change of ln(luminance) down to one cause, by rule 2 above.

    Args:
        owner: (H, W) int32 of ``edge_owner``.
        scene: (H, W) float32, the part of things that move and of their shadows and lamps.
        precipitation: The same of drops and flakes.
        lightning: The same of lightning.

    Returns:
        (H, W) int32.
    """
    sign = np.sign(scene + precipitation + lightning)
    parts = np.stack([scene, precipitation, lightning]) * sign
    causes = owner.copy()
    largest = parts.argmax(axis=0)
    causes[largest == 1] = EventCause.PRECIPITATION
    causes[largest == 2] = EventCause.LIGHTNING
    return causes

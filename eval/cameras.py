"""The camera that the shipped networks were trained with, and so have to drive with."""

from __future__ import annotations

from pedcross_env.config import CameraConfig

__all__ = ["COMPACT_CAMERA"]

COMPACT_CAMERA = CameraConfig(width_px=224, height_px=128)
"""They see 112x64 pixels of the band around the horizon, so a larger picture would only cost time."""

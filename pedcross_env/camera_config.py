"""What can be set of a camera, and the cameras that have names."""

from __future__ import annotations

import math
import types
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from pedcross_env.errors import require, unknown_name
from pedcross_env.presets import changed_preset

__all__ = ["CAMERA_PRESETS", "CameraConfig", "camera_preset"]


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraConfig:
    """A camera on the ego: a pinhole at the mirror by default, with a lens that distorts if asked for.

    60 degrees is common for forward AEB cameras; CARLA's own default is 90. ``camera_preset`` has cameras by name.
    Angles turn the car's axes in the order yaw, pitch, roll.
    """

    width_px: int = 450
    height_px: int = 256
    horizontal_fov_deg: float = 60.0  # of the pinhole: the lens's distortion comes on top
    mount_x_m: float = 0.3  # ahead of the ego's centre
    mount_y_m: float = 0.0  # to the left of it
    mount_z_m: float = 1.35  # above the ground
    yaw_deg: float = 0.0  # to the left positive
    pitch_deg: float = 0.0  # nose down positive
    roll_deg: float = 0.0  # right side down positive
    principal_point: tuple[float, float] = (0.5, 0.5)  # where the optical axis is, shares of width and height
    lens: Literal["pinhole", "brown", "fisheye"] = "pinhole"
    distortion: tuple[float, ...] = ()  # OpenCV's k1, k2, p1, p2 ("brown") or k1 to k4 ("fisheye")

    def __post_init__(self) -> None:
        require(16 <= self.width_px <= 4096, "width_px", self.width_px, "16 to 4096")
        require(16 <= self.height_px <= 4096, "height_px", self.height_px, "16 to 4096")
        require(
            10 <= self.horizontal_fov_deg <= 150, "horizontal_fov_deg", self.horizontal_fov_deg, "10 to 150"
        )
        require(-10 <= self.mount_x_m <= 10, "mount_x_m", self.mount_x_m, "-10 to 10")
        require(-3 <= self.mount_y_m <= 3, "mount_y_m", self.mount_y_m, "-3 to 3")
        require(0.2 <= self.mount_z_m <= 5, "mount_z_m", self.mount_z_m, "0.2 to 5")
        require(-180 <= self.yaw_deg <= 180, "yaw_deg", self.yaw_deg, "-180 to 180")
        require(-45 <= self.pitch_deg <= 45, "pitch_deg", self.pitch_deg, "-45 to 45")
        require(-45 <= self.roll_deg <= 45, "roll_deg", self.roll_deg, "-45 to 45")
        require(
            len(self.principal_point) == 2 and all(0.2 <= share <= 0.8 for share in self.principal_point),
            "principal_point", self.principal_point, "two shares from 0.2 to 0.8",
        )  # fmt: skip
        if self.lens not in ("pinhole", "brown", "fisheye"):
            raise unknown_name("lens", self.lens, ("pinhole", "brown", "fisheye"))
        sizes = {"pinhole": (0,), "brown": (2, 4), "fisheye": (4,)}[self.lens]
        require(
            len(self.distortion) in sizes and all(abs(k) <= 1 for k in self.distortion), "distortion",
            self.distortion, f"{' or '.join(map(str, sizes))} numbers from -1 to 1 for lens = {self.lens!r}",
        )  # fmt: skip

    @property
    def focal_px(self) -> float:
        """Focal length in pixels (square pixels)."""
        return 0.5 * self.width_px / math.tan(math.radians(self.horizontal_fov_deg) / 2)


CAMERA_PRESETS: Mapping[str, CameraConfig] = types.MappingProxyType(
    {
        "default": CameraConfig(),
        # sensor.camera.rgb of CARLA's adversarial-scenario recordings that the paper's data set was made with
        "carla": CameraConfig(width_px=1600, height_px=600, horizontal_fov_deg=90.0),
        # The paper squeezed 1600x600 to 450x256; the same view across with square pixels sees more above and below.
        "paper": CameraConfig(horizontal_fov_deg=90.0),
        # What the shipped networks see.
        "compact": CameraConfig(width_px=224, height_px=128),
        # PIE's dashcam, a Waylens Horizon: camera_params/calibration_data.json of github.com/aras62/PIE has
        # K = (1004.84, 1004.39, 960.10, 573.55), four coefficients as cv2.fisheye gives them, height 1.27 m, pitch
        # -10 degrees; verticals in its pictures converge upwards: the nose is up. Square pixels here; half a pixel
        # is added because OpenCV counts from the first pixel's centre.
        "pie": CameraConfig(
            width_px=1920, height_px=1080, horizontal_fov_deg=2 * math.degrees(math.atan(960 / 1004.6)),
            mount_z_m=1.27, pitch_deg=-10.0, principal_point=(960.60 / 1920, 574.05 / 1080), lens="fisheye",
            distortion=(-0.02748054, -0.00705505, -0.03962519, 0.01931080),
        ),
        "pie_small": CameraConfig(
            width_px=480, height_px=270, horizontal_fov_deg=2 * math.degrees(math.atan(960 / 1004.6)),
            mount_z_m=1.27, pitch_deg=-10.0, principal_point=(960.60 / 1920, 574.05 / 1080), lens="fisheye",
            distortion=(-0.02748054, -0.00705505, -0.03962519, 0.01931080),
        ),
    }
)  # fmt: skip


def camera_preset(name: str, **changes: Any) -> CameraConfig:
    """Return the camera called ``name``, with some fields changed.

    Where a config is given as a mapping, ``{"camera": "carla"}`` and ``{"camera": {"preset": "carla",
    "width_px": 800}}`` do the same.

    Args:
        name: One of CAMERA_PRESETS: default, carla, paper, compact, pie (the PIE data set's
            dashcam, a fisheye) and pie_small (the same at 480x270).
        changes: Fields of CameraConfig. Focal length and principal point follow width and height.

    Raises:
        ConfigError: For an unknown name or field; names the nearest one.
    """
    return changed_preset("camera preset", CAMERA_PRESETS, name, changes)

"""A moment in the kernels' tables: the camera's place, light, headlights and all that stands on the stage."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pedcross_env.camera.environment import constant_environment, environment, others_beams
from pedcross_env.camera.light import Light, high_beam_table, low_beam_table
from pedcross_env.camera.pinhole import CameraPose, camera_pose
from pedcross_env.camera.stage import Stage, Staged
from pedcross_env.config import CameraConfig
from pedcross_env.contracts import Snapshot
from pedcross_env.weather.weather import Weather

__all__ = ["Moment", "Moments"]

LAMP_RANGE_M = 90.0


class Moment(NamedTuple):
    """What is seen at a moment.

    Attributes:
        pose: Of the camera.
        light: Of sky, sun and lamps.
        env: (ENV_SIZE,) see kernels.lighting.
        lamps: (L, 3) street lamps near by, camera coordinates.
        beams: (B, 13) others' beams.
        table: (2, rows, columns) candela of the ego's and of others' beams.
        staged: Actors, furniture and shadows.
    """

    pose: CameraPose
    light: Light
    env: np.ndarray
    lamps: np.ndarray
    beams: np.ndarray
    table: np.ndarray
    staged: Staged


class Moments:
    """Sets up the moments of one street in one weather.

    Args:
        camera: A pinhole.
        weather: Constant.
        light: Its light, without lightning.
        lamps: (L, 3) all street lamps, metres, world.
        stage: Of the street.
    """

    def __init__(
        self, camera: CameraConfig, weather: Weather, light: Light, lamps: np.ndarray, stage: Stage
    ) -> None:
        self._camera, self._weather, self._light, self._lamps, self._stage = (
            camera, weather, light, lamps, stage,
        )  # fmt: skip
        self._constant = constant_environment(light, weather)
        self._tables = _beam_tables()

    def at(self, snapshot: Snapshot, light: Light) -> Moment:
        """Set up one moment, whose arrays the next one overwrites.

        Args:
            snapshot: Ego and actors.
            light: The weather's, or with what lightning adds to it.
        """
        pose = camera_pose(self._camera, snapshot.ego)
        return Moment(
            pose, light, self.env(snapshot, pose, light), self._near_lamps(pose, light), others_beams(pose, snapshot.actors, light),
            self.table(snapshot), self._stage.at(snapshot, pose.origin),
        )  # fmt: skip

    def all(self, snapshots: Sequence[Snapshot]) -> list[Moment]:
        """Set up several moments that last: less than half the time that each takes between two renders.

        A picture leaves nothing of Python's own in the caches.
        """
        return [
            moment._replace(staged=moment.staged.copy())
            for moment in (self.at(snapshot, self._light) for snapshot in snapshots)
        ]

    def env(self, snapshot: Snapshot, pose: CameraPose, light: Light) -> np.ndarray:
        """Light and air as a camera on the ego sees them; see ``environment``."""
        constant = self._constant if light is self._light else constant_environment(light, self._weather)
        return environment(constant, pose, snapshot.ego, light)

    def table(self, snapshot: Snapshot) -> np.ndarray:
        """(2, rows, columns) candela of the ego's beam, low or high, and of others'."""
        return self._tables[int(float(snapshot.ego["headlight"]) > 1)]

    def _near_lamps(self, pose: CameraPose, light: Light) -> np.ndarray:
        if not any(light.lamp_lx.tolist()):
            return np.zeros((0, 3))
        near = np.abs(self._lamps[:, 0] - pose.origin[0]) < LAMP_RANGE_M
        return np.ascontiguousarray(np.einsum("ij,nj->ni", pose.rotation, self._lamps[near] - pose.origin))


def _beam_tables() -> np.ndarray:
    """(ego's low or high, own or others' beam, rows, columns): others always have their low beams on."""
    low, high = low_beam_table(), high_beam_table()
    return np.ascontiguousarray(np.stack([np.stack([low, low]), np.stack([high, low])]))

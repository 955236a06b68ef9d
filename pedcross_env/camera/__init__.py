"""The camera: a street from the ego in linear radiance, with depth and instance ids."""

from pedcross_env.camera.pinhole import CameraPose, Tile, camera_pose, project, rays
from pedcross_env.camera.renderer import Renderer

__all__ = ["CameraPose", "Renderer", "Tile", "camera_pose", "project", "rays"]

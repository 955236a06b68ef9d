"""The camera: a street from the ego in linear radiance, with depth and instance ids."""

from pedcross_env.camera.actor_tables import numbers_of
from pedcross_env.camera.layers import (
    FARTHEST,
    MOST_LAYERS,
    NEAREST,
    Border,
    Layer,
    Picture,
    Seen,
    compose,
    picture_of,
    whole_picture,
)
from pedcross_env.camera.pinhole import CameraPose, camera_pose, project, rays
from pedcross_env.camera.renderer import Renderer
from pedcross_env.camera.surroundings import Surroundings

__all__ = [
    "FARTHEST",
    "MOST_LAYERS",
    "NEAREST",
    "Border",
    "CameraPose",
    "Layer",
    "Picture",
    "Renderer",
    "Seen",
    "Surroundings",
    "camera_pose",
    "compose",
    "numbers_of",
    "picture_of",
    "project",
    "rays",
    "whole_picture",
]

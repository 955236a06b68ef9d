"""What a picture shows, known without looking: classes, boxes and visible shares of pedestrians, optical flow.

Depth (metres along the optical axis) and instance ids come with every full render (contracts.Frame). From them, the poses and the
actors' records follow the rest. All functions here are pure; ``CrossingEnv.truth`` puts their results together.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from pedcross_env.camera.pinhole import camera_pose, project, rays
from pedcross_env.camera.renderer import Renderer
from pedcross_env.config import require
from pedcross_env.contracts import ActorKind, Frame, Snapshot, StaticClass

__all__ = [
    "PedestrianTruth",
    "SeenClass",
    "Truth",
    "class_image",
    "optical_flow",
    "pedestrians_in",
    "truth_of",
]

Box = tuple[float, float, float, float]


class SeenClass(IntEnum):
    """What a pixel shows."""

    SKY = 0
    GROUND = 1
    BUILDING = 2
    VEGETATION = 3
    FURNITURE = 4
    VEHICLE = 5
    PEDESTRIAN = 6


_OF_STATIC = {
    StaticClass.SKY: SeenClass.SKY,
    StaticClass.GROUND: SeenClass.GROUND,
    StaticClass.BUILDING: SeenClass.BUILDING,
    StaticClass.VEGETATION: SeenClass.VEGETATION,
    StaticClass.FURNITURE: SeenClass.FURNITURE,
}


@dataclass(frozen=True, slots=True)
class PedestrianTruth:
    """One pedestrian in one picture.

    Attributes:
        actor_id: As in the instance image.
        distance_m: Depth of its middle along the optical axis.
        amodal_box: (left, top, right, bottom) in pixels of its whole outline with what it carries, hidden or not, also beyond
            the picture's edges (by up to a picture's size; with a distorting lens only to the edges).
        visible_box: The same of the pixels that show it, None where none does.
        visible_fraction: Pixels that show it over the pixels of the picture its outline covers, 0 to 1.
        truncated_fraction: Share of its outline beyond the picture's edges.
    """

    actor_id: int
    distance_m: float
    amodal_box: Box
    visible_box: Box | None
    visible_fraction: float
    truncated_fraction: float


@dataclass(frozen=True, slots=True)
class Truth:
    """All that is known of one picture.

    Attributes:
        depth: (H, W) float32, metres along the optical axis, inf for sky.
        instance: (H, W) int32, actor id or contracts.StaticClass.
        classes: (H, W) uint8, SeenClass.
        pedestrians: Everyone whose outline reaches into the picture, by actor id, the wholly hidden included.
        flow_px: (H, W, 2) float32 or None where it was not asked for, see ``optical_flow``.
    """

    depth: np.ndarray
    instance: np.ndarray
    classes: np.ndarray
    pedestrians: tuple[PedestrianTruth, ...]
    flow_px: np.ndarray | None


def class_image(instance: np.ndarray, snapshot: Snapshot) -> np.ndarray:
    """Look up what each pixel shows.

    Args:
        instance: (H, W) int32 ids of a render of ``snapshot``.
        snapshot: Gives the actors' kinds.

    Returns:
        (H, W) uint8, values of SeenClass.
    """
    lowest = min(StaticClass)
    highest = max(int(instance.max(initial=0)), 0)
    table = np.zeros(highest - lowest + 1, np.uint8)
    for static, seen in _OF_STATIC.items():
        table[static - lowest] = seen
    for actor in snapshot.actors:
        if 0 < actor["id"] <= highest:
            walks = actor["kind"] == ActorKind.PEDESTRIAN
            table[actor["id"] - lowest] = SeenClass.PEDESTRIAN if walks else SeenClass.VEHICLE
    return table[instance - lowest]


def pedestrians_in(frame: Frame, snapshot: Snapshot, renderer: Renderer) -> tuple[PedestrianTruth, ...]:
    """Find all pedestrians of a full render; costs about 0.1 ms for each at 450x256, not a render.

    Args:
        frame: The full render of ``snapshot`` by ``renderer``.
        snapshot: Ego and actors.
        renderer: Draws the outlines.

    Raises:
        ConfigError: For a frame without ids.
    """
    instance = _ids(frame)
    height, width = instance.shape
    pose = camera_pose(renderer.config, snapshot.ego)
    found = []
    for actor in snapshot.actors[snapshot.actors["kind"] == ActorKind.PEDESTRIAN]:
        ident = int(actor["id"])
        mask, left, top = renderer.silhouette(snapshot, ident)
        outline = _box_of(mask)
        if outline is None:
            continue
        within = mask[max(0, -top) : max(0, height - top), max(0, -left) : max(0, width - left)]
        inside = int(np.count_nonzero(within))
        if inside == 0:
            continue
        area = slice(max(0, top), top + mask.shape[0]), slice(max(0, left), left + mask.shape[1])
        seen = instance[area] == ident
        box = _box_of(seen)
        middle = np.array(
            [[float(actor["x"]), float(actor["y"]), float(actor["z"]) + 0.5 * float(actor["height"])]]
        )
        found.append(PedestrianTruth(
            actor_id=ident,
            distance_m=float(project(pose, middle)[0, 2]),
            amodal_box=_moved(outline, left, top),
            visible_box=None if box is None else _moved(box, area[1].start, area[0].start),
            visible_fraction=min(1.0, int(np.count_nonzero(seen)) / inside),
            truncated_fraction=1.0 - inside / int(np.count_nonzero(mask)),
        ))  # fmt: skip
    return tuple(sorted(found, key=lambda p: p.actor_id))


def optical_flow(frame: Frame, seen: Snapshot, other: Snapshot, renderer: Renderer) -> np.ndarray:
    """Where the surface that each pixel shows is at another time, in pixels relative to the pixel.

    Exact for the static scene and for actors as rigid bodies; limbs, heads and wheels move with their body here.
    The sky only turns. Occlusion at the other time is not considered.

    Args:
        frame: The full render of ``seen``.
        seen: The scene at the frame's time.
        other: The scene at the other time, later (forward flow) or earlier.
        renderer: Gives the camera.

    Returns:
        (H, W, 2) float32, columns to the right and rows down; nan where the surface is then behind the camera or gone.
    """
    instance, depth = _ids(frame), frame.depth
    require(
        depth is not None, "frame.depth", None, "(H, W) float32: render the full frame, not luminance only"
    )
    assert depth is not None
    first, second = camera_pose(renderer.config, seen.ego), camera_pose(renderer.config, other.ego)
    height, width = instance.shape
    rows, columns = np.mgrid[0:height, 0:width].astype(np.float64) + 0.5
    ray = rays(first, columns, rows)
    sky = ~np.isfinite(depth)
    points = first.origin + np.where(sky, 0.0, depth)[..., None] * ray
    later = {int(actor["id"]): actor for actor in other.actors}
    for actor in seen.actors:
        own = instance == actor["id"]
        if not own.any():
            continue
        moved = later.get(int(actor["id"]))
        points[own] = np.nan if moved is None else _ride_along(points[own], actor, moved)
    points[sky] = second.origin + ray[sky]  # a direction has no parallax
    place = project(second, points.reshape(-1, 3)).reshape(height, width, 3)
    return np.stack([place[..., 0] - columns, place[..., 1] - rows], axis=2).astype(np.float32)


def truth_of(frame: Frame, snapshot: Snapshot, renderer: Renderer, other: Snapshot | None = None) -> Truth:
    """Put together what is known of a full render.

    Args:
        frame: The full render of ``snapshot`` by ``renderer``.
        snapshot: Ego and actors.
        renderer: What rendered it.
        other: The scene at another time, for the optical flow towards it.

    Raises:
        ConfigError: For a frame without depth and ids.
    """
    instance = _ids(frame)
    assert frame.depth is not None
    flow = None if other is None else optical_flow(frame, snapshot, other, renderer)
    return Truth(
        frame.depth,
        instance,
        class_image(instance, snapshot),
        pedestrians_in(frame, snapshot, renderer),
        flow,
    )


def _ids(frame: Frame) -> np.ndarray:
    require(
        frame.instance is not None,
        "frame.instance",
        None,
        "(H, W) int32: render the full frame, not luminance only",
    )
    assert frame.instance is not None
    return frame.instance


def _box_of(mask: np.ndarray) -> Box | None:
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if rows.size == 0:
        return None
    return float(columns[0]), float(rows[0]), float(columns[-1] + 1), float(rows[-1] + 1)


def _moved(box: Box, left: int, top: int) -> Box:
    return box[0] + left, box[1] + top, box[2] + left, box[3] + top


def _axes(actor: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Foot and the axes ahead, left, up of a body, as rows, in the world."""
    yaw, pitch = float(actor["yaw"]), float(actor["pitch"])
    c, s, cp, sp = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
    axes = np.array([[c * cp, s * cp, -sp], [-s, c, 0.0], [c * sp, s * sp, cp]])
    return np.array([float(actor["x"]), float(actor["y"]), float(actor["z"])]), axes


def _ride_along(points: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Move world points (N, 3) with a rigid body."""
    foot0, axes0 = _axes(before)
    foot1, axes1 = _axes(after)
    local = ((points - foot0)[:, None, :] * axes0[None]).sum(axis=2)
    return np.asarray(foot1 + (local[:, :, None] * axes1[None]).sum(axis=1))

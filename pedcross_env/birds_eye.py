"""The scene from above, for people."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike

from pedcross_env.camera.layout import scenery_for
from pedcross_env.camera.scenery.buildings import DEEP_M
from pedcross_env.contracts import ActorKind, Snapshot
from pedcross_env.scenario import Crosswalk, Scenario, StreetSpec
from pedcross_env.scenario.layout import carriageway_m, facade_m, side_street, to_world

__all__ = ["draw_birds_eye"]

ASPHALT, SIDEWALK, HOUSES, PAINT = (92, 92, 96), (168, 164, 156), (126, 116, 108), (236, 236, 230)
KERB, GLASS, SKIN = (206, 204, 198), (58, 66, 78), (92, 60, 42)
EGO, VEHICLE, PEDESTRIAN, BRAKE = (64, 132, 214), (206, 206, 210), (232, 120, 36), (226, 40, 40)
STRIPE_M, DASH_M, SUBPIXEL_BITS = 0.5, 3.0, 4
BENT_HALF_WIDTH_M = 24.0
KERB_M, LEAST_CAR_M = 0.25, 2.5
# of a car, in shares of its length and width: one side, from its rear; windscreen and rear window
OUTLINE = np.array([[-0.5, -0.38], [-0.42, -0.5], [0.36, -0.5], [0.47, -0.36], [0.5, 0.0]])
PANES = (
    ((0.12, -0.42), (0.26, -0.34), (0.26, 0.34), (0.12, 0.42)),
    ((-0.40, -0.32), (-0.30, -0.40), (-0.30, 0.40), (-0.40, 0.32)),
)


def draw_birds_eye(
    scenario: Scenario,
    snapshot: Snapshot,
    *,
    px_per_m: float = 8.0,
    ahead_m: float = 50.0,
    behind_m: float = 10.0,
) -> np.ndarray:
    """Draw the street around the ego, which drives upwards where the street is straight.

    Returns:
        ((ahead + behind) * px_per_m, 2 * half width * px_per_m, 3) uint8, RGB; half the width is to 2 m behind the
        house fronts, 24 m on streets that bend or cross.
    """
    street = scenario.street
    half_width_m = street.facade_y_m + 2.0 if street.straight else BENT_HALF_WIDTH_M
    origin_x_m = float(snapshot.ego["x"]) - behind_m
    height, width = round((ahead_m + behind_m) * px_per_m), round(2 * half_width_m * px_per_m)
    image = np.full((height, width, 3), HOUSES, np.uint8)

    def fill(points_m: np.ndarray, colour: tuple[int, int, int]) -> None:
        u = (half_width_m - points_m[:, 1]) * px_per_m
        v = height - (points_m[:, 0] - origin_x_m) * px_per_m
        points = np.round(np.stack([u, v], 1) * (1 << SUBPIXEL_BITS)).astype(np.int32)
        cv2.fillPoly(image, [points], colour, cv2.LINE_AA, SUBPIXEL_BITS)

    def band(x0: float, x1: float, y0: float, y1: float, colour: tuple[int, int, int]) -> None:
        fill(np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]), colour)

    far, near = origin_x_m + ahead_m + behind_m, origin_x_m
    if street.straight:
        band(near, far, -street.facade_y_m, street.facade_y_m, SIDEWALK)
        band(near, far, -street.kerb_y_m - KERB_M, street.kerb_y_m + KERB_M, KERB)
        band(near, far, -street.kerb_y_m, street.kerb_y_m, ASPHALT)
        _paint(street, street.crosswalks, near, far, fill, to_world)
    else:
        x = far - (np.arange(height)[:, None] + 0.5) / px_per_m
        y = half_width_m - (np.arange(width)[None, :] + 0.5) / px_per_m
        image[facade_m(street, x, y) > 0] = SIDEWALK
        inside = carriageway_m(street, x, y)
        image[inside > -KERB_M] = KERB
        image[inside > 0] = ASPHALT
        _paint(street, street.all_crosswalks, near, far, fill, to_world)
        if street.intersection is not None:
            side, middle = side_street(street), street.intersection.x_m
            reach = side.end_x_m
            _paint(
                side, side.crosswalks, -reach, reach, fill,
                lambda _, s, d: (middle - np.asarray(d) + 0 * np.asarray(s), np.asarray(s) + 0 * np.asarray(d), 0),
            )  # fmt: skip
            band(middle - side.kerb_y_m, middle + side.kerb_y_m, -street.kerb_y_m, street.kerb_y_m, ASPHALT)
    _houses_and_trees(street, fill)
    for actor in snapshot.actors:
        _draw_actor(actor, fill, VEHICLE)
    _draw_actor(snapshot.ego, fill, EGO)
    if snapshot.ego["brake_light"] > 0.05:
        fill(_placed(snapshot.ego, ((-0.5, -0.38), (-0.44, -0.38), (-0.44, 0.38), (-0.5, 0.38))), BRAKE)
    return image


def _paint(
    street: StreetSpec,
    zebras: tuple[Crosswalk, ...],
    near: float,
    far: float,
    fill: Callable[[np.ndarray, tuple[int, int, int]], None],
    placed: Callable[..., tuple[np.ndarray, np.ndarray, Any]],
) -> None:
    """Paint the centre line and the zebras of a street; ``placed`` puts its coordinates into the world."""

    def patch(s0: float, s1: float, d0: float, d1: float, colour: tuple[int, int, int]) -> None:
        x, y, _ = placed(street, np.array([s0, s1, s1, s0]), np.array([d0, d0, d1, d1]))
        fill(np.stack([x, y], axis=1), colour)

    for s in np.arange(np.floor(near / (2 * DASH_M)) * 2 * DASH_M, far, 2 * DASH_M):
        patch(s, s + DASH_M, -0.07, 0.07, PAINT)
    for zebra in zebras:
        s0, s1 = zebra.x_m - zebra.width_m / 2, zebra.x_m + zebra.width_m / 2
        patch(s0, s1, -0.1, 0.1, ASPHALT)
        for d in np.arange(-street.kerb_y_m + STRIPE_M / 2, street.kerb_y_m - STRIPE_M, 2 * STRIPE_M):
            patch(s0, s1, d, d + STRIPE_M, PAINT)


def _houses_and_trees(street: StreetSpec, fill: Callable[[np.ndarray, tuple[int, int, int]], None]) -> None:
    """Draw what stands beside the street: houses behind their fronts, in the colour of their walls, and crowns."""
    scenery = scenery_for(street)
    for panel in scenery.panels:
        if panel[11] <= 0 or panel[43] > 0 or panel[2] > 0:  # a side wall, or what stands on another
            continue
        start, along = panel[:2], panel[3:5]
        end, back = start + panel[6] * along, DEEP_M * np.array([-along[1], along[0]])
        fill(np.array([start, end, end + back, start + back]), _shown(0.6 * panel[8:11]))
    turn = np.linspace(0.0, 2 * np.pi, 13)[:-1]
    for group in scenery.groups[scenery.groups[:, 7] >= 0]:
        for share, tone in ((1.0, 0.55), (0.6, 0.8)):  # darker at its rim
            ring = (1 + 0.12 * np.cos(5 * turn + group[8])) * share * abs(group[11])
            fill(
                group[8:10] + np.stack([ring * np.cos(turn), ring * np.sin(turn)], axis=1),
                _shown(tone * group[13:16]),
            )


def _shown(albedo: np.ndarray) -> tuple[int, int, int]:
    """8-bit colour of a surface."""
    red, green, blue = (round(255 * float(np.clip(value, 0.0, 1.0)) ** (1 / 2.2)) for value in albedo)
    return red, green, blue


def _draw_actor(
    actor: np.ndarray, fill: Callable[[np.ndarray, tuple[int, int, int]], None], colour: tuple[int, int, int]
) -> None:
    """Draw a car with its windows, something smaller as its box, a person as shoulders and a head turned ahead."""
    if actor["kind"] == ActorKind.PEDESTRIAN:
        turn = np.linspace(0.0, 2 * np.pi, 11)[:-1]
        circle = np.stack([np.cos(turn), np.sin(turn)], axis=1)
        fill(_placed(actor, circle * (0.4, 0.62)), PEDESTRIAN)
        fill(_placed(actor, circle * 0.26 + (0.16, 0.0)), SKIN)
    elif actor["length"] < LEAST_CAR_M:
        fill(_placed(actor, ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))), colour)
    else:
        fill(_placed(actor, np.concatenate([OUTLINE, OUTLINE[::-1] * (1, -1)])), colour)
        for pane in PANES:
            fill(_placed(actor, pane), GLASS)


def _placed(actor: np.ndarray, points: ArrayLike) -> np.ndarray:
    """(N, 2) points of an actor, given in shares of its length (ahead) and width (left), in the world."""
    own = np.asarray(points) * [float(actor["length"]), float(actor["width"])]
    cos, sin = np.cos(float(actor["yaw"])), np.sin(float(actor["yaw"]))
    return np.asarray(own @ np.array([[cos, sin], [-sin, cos]]) + [float(actor["x"]), float(actor["y"])])

"""The scene from above, for people."""

from __future__ import annotations

import cv2
import numpy as np

from pedcross_env.contracts import ActorKind, Snapshot
from pedcross_env.scenario import Scenario

__all__ = ["draw_birds_eye"]

ASPHALT, SIDEWALK, HOUSES, PAINT = (92, 92, 96), (168, 164, 156), (126, 116, 108), (236, 236, 230)
EGO, VEHICLE, PEDESTRIAN, BRAKE = (64, 132, 214), (206, 206, 210), (232, 120, 36), (226, 40, 40)
STRIPE_M, DASH_M, SUBPIXEL_BITS = 0.5, 3.0, 4


def draw_birds_eye(
    scenario: Scenario,
    snapshot: Snapshot,
    *,
    px_per_m: float = 8.0,
    ahead_m: float = 50.0,
    behind_m: float = 10.0,
) -> np.ndarray:
    """Draw the street around the ego, which drives upwards.

    Returns:
        ((ahead + behind) * px_per_m, 2 * (facade + 2 m) * px_per_m, 3) uint8, RGB.
    """
    street = scenario.street
    half_width_m = street.facade_y_m + 2.0
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
    band(near, far, -street.facade_y_m, street.facade_y_m, SIDEWALK)
    band(near, far, -street.kerb_y_m, street.kerb_y_m, ASPHALT)
    for x in np.arange(np.floor(near / (2 * DASH_M)) * 2 * DASH_M, far, 2 * DASH_M):
        band(x, x + DASH_M, -0.07, 0.07, PAINT)
    for crosswalk in street.crosswalks:
        x0, x1 = crosswalk.x_m - crosswalk.width_m / 2, crosswalk.x_m + crosswalk.width_m / 2
        band(x0, x1, -0.1, 0.1, ASPHALT)
        for y in np.arange(-street.kerb_y_m + STRIPE_M / 2, street.kerb_y_m - STRIPE_M, 2 * STRIPE_M):
            band(x0, x1, y, y + STRIPE_M, PAINT)
    for actor in snapshot.actors:
        fill(_footprint(actor), PEDESTRIAN if actor["kind"] == ActorKind.PEDESTRIAN else VEHICLE)
    fill(_footprint(snapshot.ego), EGO)
    if snapshot.ego["brake_light"] > 0.05:
        fill(_footprint(snapshot.ego, (-0.5, -0.4)), BRAKE)
    return image


def _footprint(actor: np.ndarray, along: tuple[float, float] = (-0.5, 0.5)) -> np.ndarray:
    corners = np.array([[along[0], -0.5], [along[1], -0.5], [along[1], 0.5], [along[0], 0.5]])
    corners = corners * [float(actor["length"]), float(actor["width"])]
    cos, sin = np.cos(float(actor["yaw"])), np.sin(float(actor["yaw"]))
    return corners @ np.array([[cos, sin], [-sin, cos]]) + [float(actor["x"]), float(actor["y"])]

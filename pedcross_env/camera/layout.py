"""Streets that bend or are crossed, made of the tables of straight ones.

Houses follow a curve in straight pieces that meet at their ends. At an intersection both rows stop at the corner, the corner
houses get a second front along the side street, and rows of houses close all streets, so that nothing is seen through.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from functools import lru_cache

import numpy as np

from pedcross_env.camera.kernels.facade import PANEL_SIZE
from pedcross_env.camera.kernels.lighting import lamp_candela
from pedcross_env.camera.scenery import Props, Scenery, scenery_of
from pedcross_env.camera.scenery.buildings import DEEP_M, fit_bays
from pedcross_env.camera.scenery.lamps import MAP_STEP_M
from pedcross_env.contracts import StaticClass
from pedcross_env.scenario.layout import side_street, to_world
from pedcross_env.scenario.street import StreetSpec

__all__ = ["scenery_for"]

PIECE_M, CORNER_M, FLANK_M = 9.0, 6.0, 12.0
CROWN_AT = 8  # where a group holds its crown's place, if it has one


def scenery_for(street: StreetSpec) -> Scenery:
    """Return the tables of a street of any layout, cached."""
    return scenery_of(street) if street.straight else _laid_out(street)


def _along_axis(panels: np.ndarray) -> np.ndarray:
    """Which panels run along their street: fronts, not side walls."""
    return np.abs(panels[:, 3]) > 0.5


def _ends(panels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Range of x of each panel."""
    a, b = panels[:, 0], panels[:, 0] + panels[:, 3] * panels[:, 6]
    return np.minimum(a, b), np.maximum(a, b)


def _set_ends(panel: np.ndarray, low: float, high: float) -> None:
    """Let a panel along the street run from low to high, its windows fitted."""
    panel[0] = low if panel[3] > 0 else high
    panel[6], panel[27] = high - low, panel[0]
    fit_bays(panel)


def _wall(
    start: tuple[float, float], end: tuple[float, float], height: float, like: np.ndarray
) -> np.ndarray:
    """Return a plain wall from one point to another; it is seen from its right-hand side."""
    panel = np.zeros(PANEL_SIZE)
    length = math.dist(start, end)
    panel[0:2], panel[3:5] = start, (np.array(end) - np.array(start)) / length
    panel[6:8], panel[8:11] = (length, height), 0.92 * like[8:11]
    panel[12], panel[18], panel[24] = 3.0, 1.25, 1.0
    panel[26:29] = like[26], like[27], 0.0
    return panel


def _cut(panels: np.ndarray, edge: float, keep: int, side: int) -> tuple[np.ndarray, np.ndarray]:
    """End one side's row of houses exactly at ``edge``.

    Args:
        panels: Of a straight street.
        edge: Where the mouth begins, along the street.
        keep: -1 keeps what lies before the edge, 1 what lies beyond it.
        side: -1 right, 1 left.

    Returns:
        The panels of that side and on that side of the edge, and the front that now ends at it.
    """
    row = panels[(panels[:, 1] > 0) == (side > 0)].copy()
    fronts = _along_axis(row)
    low, high = _ends(row)
    # seen from the edge, the nearest end of a panel and its farthest
    near, far = (edge - high, edge - low) if keep < 0 else (low - edge, high - edge)
    enough = fronts & (far > CORNER_M)
    corner = int(np.flatnonzero(enough)[np.argmin(far[enough] - 1e-3 * row[enough, 7])])
    stays = np.where(fronts, far > CORNER_M, far > far[corner] - 0.1)
    for i in np.flatnonzero(stays & fronts & (near < near[corner] + 0.05)):
        _set_ends(row[i], edge if keep > 0 else low[i], high[i] if keep > 0 else edge)
    return row[stays], row[corner]


def _gap_walls(panels: np.ndarray) -> list[np.ndarray]:
    """Close the gaps between houses at their backs."""
    walls = []
    for side in (-1, 1):
        fronts = panels[_along_axis(panels) & ((panels[:, 1] > 0) == (side > 0)) & (panels[:, 11] > 0)]
        low, high = _ends(fronts)
        order = np.argsort(low)
        for i, j in itertools.pairwise(order):
            gap = low[j] - high[i]
            if 0.05 < gap < 8.0:
                y = fronts[i, 1] + side * (DEEP_M - 0.5)
                span = ((high[i] - 0.3, y), (low[j] + 0.3, y))
                walls.append(_wall(*(span if side > 0 else span[::-1]), 6.0, fronts[i]))
    return walls


def _closing_row(panels: np.ndarray, street: StreetSpec, at: float, facing: int) -> list[np.ndarray]:
    """Return a row of houses across the street's end, of the same kinds as along it; it faces ``facing`` along the street."""
    fronts = panels[_along_axis(panels) & (panels[:, 11] > 0)]
    reach = street.facade_y_m + DEEP_M + 2.0
    count = max(2, round(2 * reach / 13.0))
    edges = np.linspace(-reach, reach, count + 1)
    row = []
    for k in range(count):
        panel = fronts[(7 * k + 3) % len(fronts)].copy()
        # seen from its right-hand side
        panel[0], panel[1] = at, edges[k] if facing > 0 else edges[k + 1]
        panel[3], panel[4] = 0.0, float(facing)
        panel[6], panel[27], panel[28] = edges[k + 1] - edges[k], at, 0.0
        panel[16] += k
        fit_bays(panel)
        row.append(panel)
    return row


def _bent(panels: np.ndarray, street: StreetSpec) -> np.ndarray:
    """Follow a curve, fronts in straight pieces."""
    if street.curvature_per_m == 0:
        return panels
    pieces = []
    for panel in panels:
        count = max(1, math.ceil(panel[6] / PIECE_M)) if abs(panel[3]) > 0.5 else 1
        along = np.linspace(0.0, panel[6], count + 1)
        x, y, _ = to_world(street, panel[0] + panel[3] * along, panel[1] + panel[4] * along)
        for k in range(count):
            piece = panel.copy()
            piece[0], piece[1] = x[k], y[k]
            length = math.hypot(x[k + 1] - x[k], y[k + 1] - y[k])
            scale = length / (along[k + 1] - along[k])
            piece[3], piece[4] = (x[k + 1] - x[k]) / length, (y[k + 1] - y[k]) / length
            piece[6] = length
            piece[11], piece[20] = piece[11] * scale, piece[20] * scale
            fit_bays(piece)
            piece[16] += 31 * k if panel[16] > 0 else 0
            piece[27], piece[28] = panel[27] + panel[28] * along[k], panel[28] / scale
            pieces.append(piece)
    return np.array(pieces)


def _place_panels(panels: np.ndarray, middle_x: float) -> np.ndarray:
    """Turn a side street's panels from its own coordinates (s, d) to the world's (middle - d, s)."""
    out = panels.copy()
    out[:, 0], out[:, 1] = middle_x - panels[:, 1], panels[:, 0]
    out[:, 3], out[:, 4] = -panels[:, 4], panels[:, 3]
    return out


def _flank(front: np.ndarray, edge: float, keep: int, end_y: float, middle_x: float) -> list[np.ndarray]:
    """Return a corner house's second front, along the side street, and the wall behind it.

    Args:
        front: Its front along the main street, which ends at ``edge``.
        edge: x of the corner.
        keep: -1: the house lies at smaller x than its corner.
        end_y: Where the second front ends.
        middle_x: The side street's centre line.
    """
    side = 1 if end_y > 0 else -1
    low, high = sorted((float(front[1]), end_y))
    panel = front.copy()
    panel[0], panel[1] = edge, low if keep < 0 else high
    panel[3], panel[4] = 0.0, -float(keep)
    panel[6] = high - low
    panel[16] += 57
    panel[26:29] = (3.0 if edge < middle_x else 2.0), panel[1], -float(keep)
    fit_bays(panel)
    back = [(edge, end_y), (edge + keep * DEEP_M, end_y)]
    if keep * side > 0:
        back = back[::-1]
    return [panel, _wall(back[1], back[0], float(front[25] + 0.4), panel)]


def _crossed_panels(street: StreetSpec, main: Scenery, side: Scenery) -> tuple[np.ndarray, np.ndarray]:
    """Panels of the main street (still unrolled) and of the side street (in the world), cut at the corners."""
    crossing = street.intersection
    assert_crossing = side_street(street)
    if crossing is None:
        raise AssertionError("only called for crossed streets")
    ends = crossing.x_m - crossing.facade_m, crossing.x_m + crossing.facade_m
    deep = street.facade_y_m + FLANK_M
    rows, corners = [], []
    for at in (-1, 1):
        for keep, edge in zip((-1, 1), ends, strict=True):
            row, front = _cut(main.panels, edge, keep, at)
            rows.append(row)
            corners += _flank(front, edge, keep, at * deep, crossing.x_m)
    sides = []
    for at in (-1, 1):
        for keep in (-1, 1):
            row, front = _cut(side.panels, keep * deep, keep, at)
            low, high = _ends(row)
            sides.append(row[(low < crossing.length_m + 1.0) & (high > -crossing.length_m - 1.0)])
            # the wall of the first house towards the main street, above the corner house
            wall = [(keep * deep, front[1]), (keep * deep, front[1] + at * DEEP_M)]
            if keep * at > 0:
                wall = wall[::-1]
            sides.append(_wall(wall[0], wall[1], float(front[25] + 0.4), front)[None])
    for keep in (-1, 1):
        sides.append(
            np.array(_closing_row(side.panels, assert_crossing, keep * (crossing.length_m + 1.0), -keep))
        )
    own = np.concatenate(sides)
    own = np.concatenate([own, np.array(_gap_walls(own)).reshape(-1, PANEL_SIZE)])
    own[:, 26] += 2.0
    placed = np.concatenate([_place_panels(own, crossing.x_m), np.array(corners)])
    placed[:, 27] += float(main.map_frame[0] - side.map_frame[0])
    return np.concatenate(rows), placed


def _move_groups(
    scenery: Scenery, kept: np.ndarray, x: np.ndarray, y: np.ndarray, turn: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Move the kept groups rigidly to (x, y), turned; return their capsules and the groups, renumbered."""
    capsules, groups = [], []
    count = 0
    for i in np.flatnonzero(kept):
        group = scenery.groups[i].copy()
        part = scenery.capsules[int(group[0]) : int(group[1])].copy()
        c, s = math.cos(turn[i]), math.sin(turn[i])
        for k in (0, 3):
            dx, dy = part[:, k] - group[2], part[:, k + 1] - group[3]
            part[:, k], part[:, k + 1] = x[i] + c * dx - s * dy, y[i] + s * dx + c * dy
        if len(group) > CROWN_AT:
            dx, dy = group[CROWN_AT] - group[2], group[CROWN_AT + 1] - group[3]
            group[CROWN_AT : CROWN_AT + 2] = x[i] + c * dx - s * dy, y[i] + s * dx + c * dy
        group[0], group[1], group[2], group[3] = count, count + len(part), x[i], y[i]
        count += len(part)
        capsules.append(part)
        groups.append(group)
    if not groups:
        return scenery.capsules[:0], scenery.groups[:0]
    return np.concatenate(capsules), np.array(groups)


def _clear_of(scenery: Scenery, middle: float, road: float, fronts: float) -> np.ndarray:
    """Which groups stand clear of a mouth: poles beyond its rounded kerb, trees also beyond the corner houses."""
    away = np.abs(scenery.groups[:, 2] - middle)
    return away > np.where(scenery.groups[:, 6] == StaticClass.VEGETATION, fronts, road)


def _lamp_map(lamps: np.ndarray, panels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Illuminance of all street lamps on the ground for tint 1, (rows over y, columns over x), and its frame."""
    x = np.arange(panels[:, 0].min() - 20.0, panels[:, 0].max() + 20.0, MAP_STEP_M)
    y = np.arange(panels[:, 1].min() - 20.0, panels[:, 1].max() + 20.0, MAP_STEP_M)
    cosines = np.linspace(0, 1, 257)
    candela = np.array([lamp_candela(c) for c in cosines])
    out = np.zeros((len(y), len(x)))
    for lx, ly, lz in lamps:
        near_x, near_y = np.flatnonzero(np.abs(x - lx) < 40), np.flatnonzero(np.abs(y - ly) < 40)
        r2 = (x[near_x] - lx)[None, :] ** 2 + (y[near_y] - ly)[:, None] ** 2 + lz**2
        cosine = lz / np.sqrt(r2)
        out[np.ix_(near_y, near_x)] += np.interp(cosine, cosines, candela) * cosine / r2
    return out.astype(np.float32), np.array([x[0], y[0], MAP_STEP_M])


def _front_maps(main: Scenery, side: Scenery | None) -> np.ndarray:
    """Maps of lamp light on fronts: right and left of the main street, right and left of the side street."""
    if side is None:
        return main.front_lamp_maps
    maps = [*main.front_lamp_maps, *side.front_lamp_maps]
    columns = max(m.shape[1] for m in maps)
    return np.stack([np.pad(m, ((0, 0), (0, columns - m.shape[1])), mode="edge") for m in maps])


@lru_cache(maxsize=8)
def _laid_out(street: StreetSpec) -> Scenery:
    """Lay the tables of straight streets along the curve and around the intersection."""
    straight = street.straightened()
    main = scenery_of(straight, loose=False)
    crossing = street.intersection
    side = scenery_of(side_street(street), loose=False) if crossing is not None else None
    kept = np.ones(len(main.groups), bool)
    open_ground = np.ones(len(main.tree_shadows), bool)
    panels, beside = main.panels, np.zeros((0, PANEL_SIZE))
    if crossing is not None and side is not None:
        panels, beside = _crossed_panels(street, main, side)
        road = crossing.kerb_m + crossing.corner_radius_m + 0.8
        fronts = max(crossing.facade_m, road + crossing.crosswalk_width_m) + 2.5
        kept = _clear_of(main, crossing.x_m, road, fronts)
        open_ground = np.abs(main.tree_shadows[:, 0] - crossing.x_m) > fronts
    low, high = _ends(main.panels[_along_axis(main.panels)])
    closing = _closing_row(main.panels, straight, float(low.min()) + 0.5, 1)
    closing += _closing_row(main.panels, straight, float(high.max()) - 0.5, -1)
    panels = np.concatenate([panels, np.array(_gap_walls(panels) + closing)])
    x, y, heading = to_world(street, main.groups[:, 2], main.groups[:, 3])
    capsules, groups = _move_groups(main, kept, x, y, heading)
    lamps = _clear_lamps(main, kept)
    lx, ly, _ = to_world(street, lamps[:, 0], lamps[:, 1])
    lamps = np.stack([lx, ly, lamps[:, 2]], axis=1)
    crowns = main.tree_shadows[open_ground].copy()
    crowns[:, 0], crowns[:, 1], _ = to_world(street, crowns[:, 0], crowns[:, 1])
    if crossing is not None and side is not None:
        more = _side_furniture(street, side)
        groups_2 = more[1].copy()
        groups_2[:, :2] += len(capsules)
        capsules, groups = np.concatenate([capsules, more[0]]), np.concatenate([groups, groups_2])
        lamps, crowns = np.concatenate([lamps, more[2]]), np.concatenate([crowns, more[3]])
    placed = np.concatenate([_bent(panels, street), beside])
    placed[:, 29] = 1.0  # fronts of all streets may share pixels where they meet
    ground, frame = _lamp_map(lamps, placed)
    return replace(
        main, panels=placed, capsules=capsules, groups=groups, lamps=lamps, ground_lamp_map=ground, ground_frame=frame,
        front_lamp_maps=_front_maps(main, side), tree_shadows=crowns, props=_placed_props(street, main.props),
    )  # fmt: skip


def _placed_props(street: StreetSpec, props: Props) -> Props:
    """Furniture along the curve and clear of the intersection; houses that bend or turn a corner have flat roofs."""
    stays = props.idents[:, 0] == StaticClass.FURNITURE
    crossing = street.intersection
    if crossing is not None:
        reach = crossing.facade_m + crossing.corner_radius_m + crossing.crosswalk_width_m + 3.0
        stays &= np.abs(props.numbers[:, 0] - crossing.x_m) > reach
    numbers = props.numbers[stays]
    numbers[:, 0], numbers[:, 1], heading = to_world(street, numbers[:, 0], numbers[:, 1])
    numbers[:, 3] += heading
    return Props(numbers, props.idents[stays], props.looks[stays])


def _clear_lamps(scenery: Scenery, kept: np.ndarray) -> np.ndarray:
    """Lamps whose pole is still there."""
    poles = scenery.groups[kept & (scenery.groups[:, 6] == StaticClass.FURNITURE)]
    if not len(poles):
        return scenery.lamps[:0]
    apart = np.abs(scenery.lamps[:, None, :2] - poles[None, :, 2:4]).max(axis=2).min(axis=1)
    return scenery.lamps[apart < 2.0]


def _side_furniture(
    street: StreetSpec, side: Scenery
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Capsules, groups, lamps and crowns of the side street, in the world."""
    crossing = street.intersection
    if crossing is None:
        raise AssertionError("only called for crossed streets")
    road = street.kerb_y_m + crossing.corner_radius_m + 0.8
    fronts = max(street.facade_y_m, road + crossing.crosswalk_width_m) + 2.5
    kept = _clear_of(side, 0.0, road, fronts) & (np.abs(side.groups[:, 2]) < crossing.length_m)
    quarter = np.full(len(side.groups), 0.5 * math.pi)
    capsules, groups = _move_groups(
        side, kept, crossing.x_m - side.groups[:, 3], side.groups[:, 2].copy(), quarter
    )
    lamps = _clear_lamps(side, kept)
    lamps = np.stack([crossing.x_m - lamps[:, 1], lamps[:, 0], lamps[:, 2]], axis=1)
    crowns = side.tree_shadows[
        (np.abs(side.tree_shadows[:, 0]) > fronts) & (np.abs(side.tree_shadows[:, 0]) < crossing.length_m)
    ].copy()
    crowns[:, 0], crowns[:, 1] = crossing.x_m - crowns[:, 1], crowns[:, 0].copy()
    return capsules, groups, lamps, crowns

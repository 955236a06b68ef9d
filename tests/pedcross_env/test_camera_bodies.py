"""Convex bodies against geometry: exact coverage, depth of the face that is seen, edges that faces have in common."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from camera_scenes import renderer, snapshot, vehicle
from scipy.spatial import ConvexHull, HalfspaceIntersection

from pedcross_env.camera.kernels.jit import entry
from pedcross_env.camera.kernels.polyhedra import PLACED, draw_polyhedron, polyhedron_work
from pedcross_env.camera.model_table import model_table
from pedcross_env.camera.models import ModelBuilder, model_index

HEIGHT, WIDTH = 60, 450
FOCAL, CX, CY = 400.0, 225.0, 30.0
CONVEX_M = 0.02  # what the corner of a part may stand out beyond the plane of one of its faces


@entry
def _draw(faces, whole, mesh, placed, facing, colours, xs, scratch, work, spans, behind):
    draw_polyhedron(
        0, faces, 0, whole, mesh, placed, facing, colours, (FOCAL, CX, CY), xs, (HEIGHT, WIDTH), scratch, work, spans,
        behind,
    )  # fmt: skip


def _cube(centre, size, turn):
    """Corners in camera coordinates, and faces (corners, counter-clockwise seen from outside)."""
    builder = ModelBuilder()
    builder.box((-0.5, 0.5), (-0.5, 0.5), (-0.5, 0.5), 0)
    model = builder.build(1.0, 1.0, 1.0)
    q, _ = np.linalg.qr(turn)
    q *= np.sign(np.linalg.det(q))
    return np.array(model.points) * size @ q.T + centre, [face for face, _, _ in model.parts[0]]


def _draw_cube(corners, faces, *, whole=True, channels=1, behind=True):
    """Draw with face k of radiance k + 1; return premultiplied radiance, coverage, premultiplied inverse depth."""
    starts = np.concatenate([[0], np.cumsum([len(f) for f in faces])])
    owner = {(a, b): k for k, f in enumerate(faces) for a, b in zip(f, f[1:] + f[:1], strict=True)}
    beyond = [owner[b, a] for f in faces for a, b in zip(f, f[1:] + f[:1], strict=True)]
    mesh = (starts, np.concatenate(faces), np.zeros(len(faces), np.int64), np.array(beyond))
    placed = np.full((len(corners), PLACED), np.nan)
    placed[:, :3] = corners
    seen = corners[:, 2] >= 0.1
    placed[seen, 3:] = (CX, CY) + FOCAL * corners[seen, :2] / corners[seen, 2:]
    facing = np.zeros((len(faces), 4))
    for k, face in enumerate(faces):
        p = corners[list(face)]
        normal = np.cross(p, np.roll(p, -1, axis=0)).sum(axis=0)
        distance = normal @ p[0]
        if distance < 0:
            a, b, c = normal / distance
            facing[k] = a / FOCAL, b / FOCAL, c - (a * CX + b * CY) / FOCAL, 1.0
    colours = np.repeat(np.arange(1.0, len(faces) + 1, dtype=np.float32)[:, None], channels, axis=1)
    xs = np.arange(WIDTH, dtype=np.float32) + np.float32(0.5)
    scratch = (
        np.zeros((channels, HEIGHT, WIDTH), np.float32),
        *(np.zeros((HEIGHT, WIDTH), np.float32) for _ in "ab"),
    )
    spans = np.tile(np.array([1 << 30, 0], np.int32), (HEIGHT + 1, 1))
    work = polyhedron_work.py_func(channels, WIDTH)
    _draw(len(faces), whole, mesh, placed, facing, colours, xs, scratch, work, spans, behind)
    assert not work[4].any(), "the work space is left as it was"
    return scratch, facing


def _area_in_image(corners):
    """Area of a body's outline within the image, in pixels, by half planes."""
    image = (CX, CY) + FOCAL * corners[:, :2] / corners[:, 2:]
    middle = np.clip(image.mean(axis=0), (0.5, 0.5), (WIDTH - 0.5, HEIGHT - 0.5))
    frame = np.array([[-1.0, 0, 0], [0, -1.0, 0], [1.0, 0, -WIDTH], [0, 1.0, -HEIGHT]])
    return ConvexHull(
        HalfspaceIntersection(np.vstack([ConvexHull(image).equations, frame]), middle).intersections
    ).volume


# a few pixels; some; larger than what is worked on at a time; over the left, the right, and the upper and lower border
PLACES = [
    (0.2, 0.1, 40.0),
    (-1.0, 0.1, 8.0),
    (0.0, 0.0, 2.0),
    (-3.2, 0.0, 6.0),
    (3.2, 0.1, 6.0),
    (0.3, 0.0, 1.6),
]


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("seed", range(3))
def test_a_body_covers_what_its_outline_encloses(place, seed):
    turn = np.random.default_rng(seed).normal(size=(3, 3))
    corners, faces = _cube(place, 0.9, turn)
    (_, cover, _), _ = _draw_cube(corners, faces)
    area = _area_in_image(corners)
    assert cover.sum(dtype=float) == pytest.approx(area, rel=2e-5)
    assert cover.max() <= 1.0


@pytest.mark.parametrize("place", PLACES)
def test_pixels_have_the_colour_and_the_depth_of_the_face_they_see(place):
    corners, faces = _cube(place, 0.9, np.random.default_rng(7).normal(size=(3, 3)))
    (radiance, cover, inverse), facing = _draw_cube(corners, faces)
    rows, columns = np.mgrid[:HEIGHT, :WIDTH] + 0.5
    depths = facing[:, 0, None, None] * columns + facing[:, 1, None, None] * rows + facing[:, 2, None, None]
    pure = (cover > 1 - 1e-6) & (np.abs(radiance[0] - np.round(radiance[0])) < 1e-5)
    face = np.round(radiance[0][pure]).astype(int) - 1
    assert set(face) <= set(np.flatnonzero(facing[:, 3]))
    expected = depths[face, rows[pure].astype(int), columns[pure].astype(int)]
    assert inverse[pure] == pytest.approx(expected, rel=2e-5)


@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("place", PLACES)
def test_edges_in_common_give_what_the_faces_give_one_by_one(place, channels):
    corners, faces = _cube(place, 0.9, np.random.default_rng(3).normal(size=(3, 3)))
    together, _ = _draw_cube(corners, faces, channels=channels)
    apart, _ = _draw_cube(corners, faces, channels=channels, whole=False)
    for a, b in zip(together, apart, strict=True):
        assert a == pytest.approx(b, abs=3e-5)
    assert (together[0] == together[0][0]).all()


def test_a_slab_that_reaches_behind_the_camera_covers_what_is_below_its_far_edge():
    corners, faces = _cube((0.0, 0.0, 0.0), 1.0, np.eye(3))
    low, high = np.array([-20.0, 1.0, -5.0]), np.array([20.0, 2.0, 50.0])
    corners = np.where(corners < 0, low, high)
    (_, cover, _), facing = _draw_cube(corners, faces, whole=False)
    assert np.count_nonzero(facing[:, 3]) == 1
    # its top ends FOCAL / 50 rows below the middle, 20 columns wider on either side with every row
    narrow = 20.0 * ((WIDTH / 40.0) ** 2 - (FOCAL / 50.0) ** 2)
    assert cover.sum(dtype=float) == pytest.approx(narrow + WIDTH * (HEIGHT - CY - WIDTH / 40.0), rel=1e-5)


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("seed", range(12))
def test_no_pixel_of_a_body_is_nearer_or_farther_than_its_corners(place, seed):
    """A face seen nearly edge-on is steep: its plane at a pixel's middle may be metres from what is seen there."""
    turn = np.random.default_rng(seed).normal(size=(3, 3)) * (1.0, 0.02, 1.0) + np.eye(3)
    corners, faces = _cube(place, 0.9, turn)
    (_, cover, inverse), _ = _draw_cube(corners, faces)
    seen = cover > 1e-5
    depth = cover[seen] / inverse[seen]
    assert depth.min() > corners[:, 2].min() * (1 - 1e-5)
    assert depth.max() < corners[:, 2].max() * (1 + 1e-5)


def test_two_faces_share_each_edge_of_the_models_that_ship():
    table = model_table()
    starts, corners, beyond = table.face_start, table.face_corners, table.edge_beyond
    edges = {}
    for face in np.flatnonzero(table.face_detail == 0):
        run = corners[starts[face] : starts[face + 1]].tolist()
        part = int(np.searchsorted(table.part_faces, face, side="right"))
        edges.update({(part, a, b): face for a, b in zip(run, run[1:] + run[:1], strict=True)})
    for face, painted in enumerate(table.face_detail):
        run = corners[starts[face] : starts[face + 1]].tolist()
        part = int(np.searchsorted(table.part_faces, face, side="right"))
        for k, (a, b) in enumerate(zip(run, run[1:] + run[:1], strict=True)):
            expected = -1 if painted else edges[part, b, a]
            assert beyond[starts[face] + k] == expected


def test_faces_of_the_models_that_ship_are_flat():
    table = model_table()
    model = np.repeat(
        np.arange(len(table.model_parts) - 1), np.diff(table.part_faces[table.model_parts])
    )  # of each face
    for face in np.flatnonzero(table.face_detail == 0):
        run = table.face_corners[table.face_start[face] : table.face_start[face + 1]]
        corners = table.points[table.model_points[model[face]] + run]
        normal, distance = table.face_plane[face, :3], table.face_plane[face, 3]
        assert np.abs(corners @ normal - distance).max() < 1e-8 * np.linalg.norm(normal)


def test_parts_of_the_models_that_ship_are_convex():
    table = model_table()
    for model, first in enumerate(table.model_points[:-1]):
        points = table.points[first : table.model_points[model + 1]]
        for part in range(table.model_parts[model], table.model_parts[model + 1]):
            faces = np.arange(table.part_faces[part], table.part_faces[part + 1])
            faces = faces[table.face_detail[faces] == 0]
            runs = [table.face_corners[table.face_start[f] : table.face_start[f + 1]] for f in faces]
            corners = points[np.unique(np.concatenate(runs))]
            for normal, distance in ((table.face_plane[f, :3], table.face_plane[f, 3]) for f in faces):
                assert (corners @ normal - distance).max() < CONVEX_M * np.linalg.norm(normal)


def test_faces_that_meet_at_a_blunt_edge_are_lit_alike_and_those_of_a_box_as_they_are():
    table = model_table()
    plane = table.face_plane[:, :3] / np.linalg.norm(table.face_plane[:, :3], axis=1)[:, None]
    bend = table.face_bend[:, :3] / np.linalg.norm(table.face_bend[:, :3], axis=1)[:, None]
    owner = np.repeat(np.arange(len(table.face_start) - 1), np.diff(table.face_start))
    pairs = np.stack([owner, table.edge_beyond], axis=1)[table.edge_beyond >= 0]
    a, b = pairs[table.face_material[pairs[:, 0]] == table.face_material[pairs[:, 1]]].T
    sharp, lit = (plane[a] * plane[b]).sum(axis=1), (bend[a] * bend[b]).sum(axis=1)
    blunt = (sharp > np.cos(np.deg2rad(28.0))) & (sharp < 1 - 1e-6)
    assert np.median(np.arccos(np.minimum(1.0, lit[blunt]))) < 0.75 * np.median(np.arccos(sharp[blunt]))
    truck = model_index("truck")[0]  # its first part is a box, painted only
    box = np.arange(
        table.part_faces[table.model_parts[truck]], table.part_faces[table.model_parts[truck] + 1]
    )
    assert bend[box] == pytest.approx(plane[box])


@pytest.mark.parametrize("name", ["hatchback", "sedan", "suv"])
def test_a_cabin_stands_well_within_the_shoulders_of_its_car(name):
    """Where they all but touched, the sky's light on the shoulder was seen in dashes."""
    number = model_index(name)[0]
    table = model_table()
    points = table.points[table.model_points[number] : table.model_points[number + 1]]
    parts = [
        np.unique(np.concatenate([
            table.face_corners[table.face_start[f] : table.face_start[f + 1]]
            for f in range(table.part_faces[p], table.part_faces[p + 1]) if table.face_detail[f] == 0
        ]))
        for p in range(table.model_parts[number], table.model_parts[number] + 2)
    ]  # fmt: skip
    body, cabin = points[parts[0]], points[parts[1]]
    belt = body[:, 2].max()
    foot = cabin[cabin[:, 2] < belt]
    shoulder = np.abs(body[np.isclose(body[:, 2], belt), 1]).max()
    assert np.abs(foot[:, 1]).max() < shoulder - 0.03


@pytest.mark.parametrize("turn_deg", [-20.0, 20.0])
def test_a_twisted_body_lies_within_its_rings_corners_and_bulges_outwards(turn_deg):
    model = _twisted(turn_deg)
    hull = ConvexHull(model.points)
    faces = [face for face, _, _ in model.parts[0]]
    assert len(faces) == 2 + 2 * 4
    volume = 0.0
    for face in faces:
        a, *rest = np.array(model.points)[list(face)]
        volume += sum(a @ np.cross(p, q) for p, q in pairwise(rest)) / 6
    assert volume == pytest.approx(hull.volume)


@pytest.mark.parametrize("seed", range(40))
def test_no_part_of_a_twisted_body_gives_less_than_no_light(seed):
    """Seen edge-on, a twisted face that is drawn as one turns both towards the camera and away from it."""
    model = _twisted(20.0)
    turn, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    corners = np.array(model.points) @ turn.T + (0.0, 0.0, 20.0)
    faces = [face for face, _, _ in model.parts[0]]
    (radiance, cover, inverse), _ = _draw_cube(corners, faces)
    assert radiance[0].min() >= -1e-5
    assert (radiance[0] <= len(faces) * cover + 1e-4).all()
    assert cover.sum(dtype=float) == pytest.approx(_area_in_image(corners), rel=1e-4)
    assert inverse.max() <= 1.01 / corners[:, 2].min()


def _twisted(turn_deg):
    """A tower whose roof is turned against its foot: none of its walls is flat."""
    turns = [np.deg2rad(45.0 + 90.0 * k) for k in range(4)]
    more = np.deg2rad(turn_deg)
    builder = ModelBuilder()
    builder.loft(
        [[(np.cos(t), np.sin(t), 0.0) for t in turns], [(np.cos(t + more), np.sin(t + more), 2.0) for t in turns]], 0,
    )  # fmt: skip
    return builder.build(2.0, 2.0, 2.0)


@pytest.mark.parametrize("name", ["hatchback", "sedan", "suv", "van", "bus", "truck", "motorcycle"])
def test_vehicles_give_no_negative_light(name):
    number, size = model_index(name)
    street = renderer()
    for away in np.arange(5.0, 30.0, 0.75):
        body = vehicle(
            5, away, -4.43, model=number, length=size.length_m, width=size.width_m, height=size.height_m
        )
        assert street.render(snapshot(body), luminance_only=True).luminance.min() > 0.0

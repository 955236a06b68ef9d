"""All models as the kernels' tables: corners, faces, what lies beyond their edges and how they are lit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import lru_cache

import numpy as np

from pedcross_env.camera.models import Face, Model, Point, plane_of, registered_models

__all__ = ["ModelTable", "model_table"]

BLUNT = np.cos(np.deg2rad(28.0))  # faces that meet at a smaller angle are lit as one bent sheet


@dataclass(frozen=True, slots=True)
class ModelTable:
    """All models, concatenated: vehicles in the order of VEHICLE_MODELS, then props.

    Attributes:
        points: (V, 3) corners in metres at the nominal size, origin on the ground under the centre.
        model_points: (M + 1,) where a model's points start.
        model_parts: (M + 1,) where a model's polyhedra start.
        part_faces: (P + 1,) where a polyhedron's faces start.
        face_start: (F + 1,) where a face's corners start.
        face_corners: (K,) indices relative to the model's first point.
        face_material: (F,).
        face_detail: (F,) 0 bounds its polyhedron, 1 is painted on it, 2 is painted and seen near by only.
        face_plane: (F, 4) normal outwards, as long as the face has twice the area, and what it gives on the face.
        nominal: (M, 3) length, width, height.
        face_middle: (F, 3) mean of its corners.
        edge_beyond: (K,) for the edge from each of ``face_corners`` to its face's next: the face of the same polyhedron
            that shares it, -1 where none does (painted faces share none).
        face_bend: (F, 4) normal that a face is lit by: bent towards those it meets at a blunt edge, as sheet metal is; 1 where
            that is not its own.
    """

    points: np.ndarray
    model_points: np.ndarray
    model_parts: np.ndarray
    part_faces: np.ndarray
    face_start: np.ndarray
    face_corners: np.ndarray
    face_material: np.ndarray
    face_detail: np.ndarray
    face_plane: np.ndarray
    nominal: np.ndarray
    face_middle: np.ndarray
    edge_beyond: np.ndarray
    face_bend: np.ndarray

    @property
    def arrays(self) -> tuple[np.ndarray, ...]:
        """All of them, as kernels take them."""
        return tuple(getattr(self, f.name) for f in fields(self))


def _beyond(part: Sequence[Face], first: int) -> list[int]:
    """Return for each edge of a part's faces the number of the face on its other side, which runs along it the other way.

    Args:
        part: Its faces.
        first: Number of the first.
    """
    runs = [list(zip(face, face[1:] + face[:1], strict=True)) for face, _, _ in part]
    bounding = [k for k, (_, _, painted) in enumerate(part) if painted == 0]
    owner = {edge: k for k in bounding for edge in runs[k]}
    beyond = []
    for k, run in enumerate(runs):
        for a, b in run:
            other = owner.get((b, a)) if owner.get((a, b)) == k else None
            beyond.append(-1 if other is None else first + other)
    return beyond


def _bent(part: Sequence[Face], planes: np.ndarray, beyond: Sequence[int], first: int) -> np.ndarray:
    """Return (faces, 4) as ``ModelTable.face_bend``: the mean, by area, with the faces beyond their blunt edges.

    Args:
        part: Its faces.
        planes: (faces, 4) as ``ModelTable.face_plane``.
        beyond: From ``_beyond``.
        first: Number of the part's first face.
    """
    normals = planes[:, :3]
    upright = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    bent, edge = normals.copy(), 0
    for k, (face, material, _) in enumerate(part):
        for other in (number - first for number in beyond[edge : edge + len(face)] if number >= 0):
            if part[other][1] == material and upright[k] @ upright[other] > BLUNT:
                bent[k] += normals[other]
        edge += len(face)
    return np.column_stack([bent, (bent != normals).any(axis=1)])


def model_table() -> ModelTable:
    """Return the table of all models registered so far."""
    return _table_of(registered_models())


@lru_cache(maxsize=1)
def _table_of(models: tuple[Model, ...]) -> ModelTable:
    points: list[Point] = []
    model_points, model_parts, part_faces, face_start = [0], [0], [0], [0]
    corners: list[int] = []
    material: list[int] = []
    detail: list[int] = []
    planes: list[np.ndarray] = []
    middles: list[np.ndarray] = []
    beyond: list[int] = []
    bends: list[np.ndarray] = []
    for model in models:
        points += model.points
        places = np.array(model.points)
        for part in model.parts:
            own, first = _beyond(part, len(material)), len(material)
            beyond += own
            for face, surface, painted in part:
                corners += face
                planes.append(plane_of([model.points[i] for i in face]))
                middles.append(places[list(face)].mean(axis=0))
                face_start.append(len(corners))
                material.append(surface)
                detail.append(painted)
            bends.append(_bent(part, np.array(planes[first:]), own, first))
            part_faces.append(len(material))
        model_points.append(len(points))
        model_parts.append(len(part_faces) - 1)
    as_int = lambda values: np.array(values, np.int64)  # noqa: E731
    return ModelTable(
        np.array(points), as_int(model_points), as_int(model_parts), as_int(part_faces), as_int(face_start),
        as_int(corners), as_int(material), as_int(detail), np.array(planes), np.array([model.size for model in models]),
        np.array(middles), as_int(beyond), np.concatenate(bends),
    )  # fmt: skip

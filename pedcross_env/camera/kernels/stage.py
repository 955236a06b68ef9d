"""All tables of one moment in one step: after a picture is drawn Python finds nothing of its own in the caches, and each call of
numpy costs several times what it costs alone."""

from __future__ import annotations

import numpy as np

from pedcross_env.camera.kernels.jit import allocating, allocating_kernel, kernel
from pedcross_env.camera.kernels.shade import shrink_far, sunlit_actors
from pedcross_env.camera.kernels.shadows import cast_shadows
from pedcross_env.contracts import ACTOR_DTYPE

__all__ = ["HEADLIGHT", "MODEL", "NUMBERS", "set_stage"]

NUMBERS = (
    "x", "y", "z", "yaw", "pitch", "model", "length", "width", "height", "gait_phase", "gait_stride", "head_yaw", "brake_light",
    "headlight",
)  # fmt: skip
SIZE = ACTOR_DTYPE.itemsize


def _bytes_of(name: str) -> tuple[int, int]:
    """First byte of a field of a record, and the one beyond its last."""
    assert ACTOR_DTYPE.fields is not None
    kind, first = ACTOR_DTYPE.fields[name][:2]
    return first, first + kind.itemsize


MODEL, HEADLIGHT = NUMBERS.index("model"), NUMBERS.index("headlight")
PLACE, BRAKE_END = _bytes_of("x")[0], _bytes_of("brake_light")[1]
MODEL_AT, HEADLIGHT_AT, LOOKS_AT = _bytes_of("model"), _bytes_of("headlight"), (0, PLACE)
HEIGHT_AT, ACCESSORY_AT = _bytes_of("height"), _bytes_of("accessory")


@kernel
def _differences(record, shown, field):
    """How many of the bytes from the first to the one beyond the last of a field differ."""
    count = 0
    for k in range(field[0], field[1]):
        count += record[k] != shown[k]
    return count


@kernel
def _look_alike(records, shown):
    """Whether records show the same actors, wherever they are: identity, kind, model, seed, height and what they carry."""
    if records.shape[0] != shown.shape[0]:
        return False
    for at in range(0, records.shape[0], SIZE):
        one, other = records[at : at + SIZE], shown[at : at + SIZE]
        if (
            _differences(one, other, LOOKS_AT) + _differences(one, other, HEIGHT_AT)
            + _differences(one, other, ACCESSORY_AT) > 0
        ):  # fmt: skip
            return False
    return True


@allocating_kernel
def _numbers_of(record, out):
    """Fill a row of NUMBERS: all but three lie side by side in a record, the speed where NUMBERS has the model."""
    side_by_side = record[PLACE:BRAKE_END].view(np.float64)
    for k in range(HEADLIGHT):
        out[k] = side_by_side[k]
    out[MODEL] = record[MODEL_AT[0] : MODEL_AT[1]].view(np.int32)[0]
    out[HEADLIGHT] = record[HEADLIGHT_AT[0] : HEADLIGHT_AT[1]].view(np.float64)[0]


@allocating
def set_stage(records, shown, furniture, fading, camera, sunlight, everyone, cast, shadows):
    """Fill the tables of a moment, unless others are seen than they were made for.

    Args:
        records: (M + 1,) uint8, the bytes of the actors' and then of the ego's ACTOR_DTYPE.
        shown: The same for which the tables were made.
        furniture: (R, 14) as kernels.scene.
        fading: (which of it keeps its size (R,), range, metres over which it fades), see kernels.shade.shrink_far.
        camera: (3,) its place.
        sunlight: (walls, sun, shear, whether it casts shadows), see kernels.shade and kernels.shadows.
        everyone: (numbers (N, 14), kinds, builds) of actors and ego; the first is filled.
        cast: (numbers (N - 1 + R, 14), shares that the sun reaches), filled.
        shadows: (polygons, their facts, how many there are already, capsules, how many there are already), filled.

    Returns:
        The numbers of polygons and capsules; -1, -1 if others are seen.
    """
    if not _look_alike(records, shown):
        return -1, -1
    lasting, range_m, fade_m = fading
    walls, sun, shear, sunny = sunlight
    everybody, kinds, builds = everyone
    numbers, sunlit = cast
    polygons, info, houses, capsules, trees = shadows
    n = everybody.shape[0] - 1
    for i in range(n + 1):
        _numbers_of(records[i * SIZE : (i + 1) * SIZE], everybody[i])
    for i in range(n):
        for k in range(everybody.shape[1]):
            numbers[i, k] = everybody[i, k]
    shrink_far(furniture, lasting, camera, range_m, fade_m, numbers[n:])
    sunlit_actors(walls, sun, numbers, sunlit[:n])
    return cast_shadows(everybody, kinds, builds, shear, sunny, polygons, info, houses, capsules, trees)

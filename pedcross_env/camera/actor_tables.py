"""What stands and moves as the kernels' tables; appearance is looked up once per actor, not once per frame."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pedcross_env.camera.kernels.people import MAX_BODY, PART_SIZE
from pedcross_env.camera.kernels.pose import BUILD_SIZE
from pedcross_env.camera.kernels.stage import HEADLIGHT, MODEL, NUMBERS
from pedcross_env.camera.people import person_of
from pedcross_env.camera.riders import rider_of
from pedcross_env.camera.vehicles import PAINTS
from pedcross_env.contracts import ACTOR_DTYPE, ActorKind
from pedcross_env.scenario import ACCESSORIES, VEHICLE_MODELS

__all__ = ["ActorTables", "Cast", "numbers_of"]


def _fields() -> np.dtype[np.void]:
    """ACTOR_DTYPE seen as few fields, which are copied quicker than many: its numbers lie side by side, the speed where NUMBERS has the model."""
    fields = ACTOR_DTYPE.fields
    assert fields is not None
    at = {name: field[1] for name, field in fields.items()}
    return np.dtype(
        {
            "names": ["looks", "numbers", "model", "height", "accessory", "headlight"],
            "formats": [f"V{at['x']}", ("<f8", (HEADLIGHT,)), "<i4", "<f8", "<i4", "<f8"],
            "offsets": [0, at["x"], at["model"], at["height"], at["accessory"], at["headlight"]],
            "itemsize": ACTOR_DTYPE.itemsize,
        }
    )


FIELDS = _fields()


def numbers_of(actors: np.ndarray) -> np.ndarray:
    """Return (N, 13) float64 of (N,) ACTOR_DTYPE: NUMBERS before the headlight, with the speed in the model's place."""
    return actors.view(FIELDS)["numbers"].copy()


class Cast(NamedTuple):
    """Actors as tables.

    Attributes:
        numbers: (N, 14) float64: NUMBERS.
        idents: (N, 2) int64: instance id, ActorKind; PEDESTRIAN for cyclists too, who are drawn as bodies are.
        looks: (N, 8, 4) a vehicle's paint in [:, 0, :3].
        builds: (N, BUILD_SIZE) proportions of pedestrians and cyclists.
        bodies: (N, MAX_BODY, PART_SIZE) their capsules.
    """

    numbers: np.ndarray
    idents: np.ndarray
    looks: np.ndarray
    builds: np.ndarray
    bodies: np.ndarray


class ActorTables:
    """Makes tables of actors.

    Args:
        raining: Whether umbrellas are up.
    """

    def __init__(self, raining: bool) -> None:
        self._raining = raining
        self._known: dict[bytes, tuple[np.ndarray, ...]] = {}

    def of(self, actors: np.ndarray) -> Cast:
        """Return the tables of (N,) ACTOR_DTYPE; all but the numbers are shared between calls that show the same actors."""
        numbers, fields = np.empty((len(actors), len(NUMBERS))), actors.view(FIELDS)
        numbers[:, :HEADLIGHT] = fields["numbers"]
        numbers[:, MODEL], numbers[:, HEADLIGHT] = fields["model"], fields["headlight"]
        key = fields["looks"].tobytes() + fields["height"].tobytes() + fields["accessory"].tobytes()
        if key not in self._known:
            self._known[key] = self._appearance(actors)
        return Cast(numbers, *self._known[key])

    def _appearance(self, actors: np.ndarray) -> tuple[np.ndarray, ...]:
        n = len(actors)
        idents, looks = np.empty((n, 2), np.int64), np.zeros((n, 8, 4))
        builds, bodies = np.zeros((n, BUILD_SIZE)), np.zeros((n, MAX_BODY, PART_SIZE))
        idents[:, 0], idents[:, 1] = actors["id"], actors["kind"]
        for i, actor in enumerate(actors):
            model, seed = int(actor["model"]), int(actor["seed"])
            if actor["kind"] == ActorKind.VEHICLE and VEHICLE_MODELS[model] == "cyclist":
                rider = rider_of(seed)
                builds[i], bodies[i] = rider.build, rider.body
                idents[i, 1] = ActorKind.PEDESTRIAN  # for the kernels: a body, not a polyhedron
            elif actor["kind"] == ActorKind.PEDESTRIAN:
                accessory = ACCESSORIES[int(actor["accessory"])]
                person = person_of(model, seed, float(actor["height"]), accessory, self._raining)
                builds[i], bodies[i] = person.build, person.body
            else:
                painted = seed >> 32 if VEHICLE_MODELS[model] == "car_door" else model  # as its car is
                rng = np.random.default_rng([seed & 0xFFFFFFFF, painted, 33])
                looks[i, 0, :3] = PAINTS[rng.integers(len(PAINTS))]
        return idents, looks, builds, bodies

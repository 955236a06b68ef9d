"""Records of actors: what never changes is written once, what moves is filled into a copy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pedcross_env.config import EgoConfig
from pedcross_env.contracts import ACTOR_DTYPE, ActorKind
from pedcross_env.scenario.scenario import ACCESSORIES, PEDESTRIAN_MODELS, VEHICLE_MODELS, Scenario
from pedcross_env.scenario.sizes import pedestrian_size, vehicle_size
from pedcross_env.world.doors import DOOR_MODEL
from pedcross_env.world.ego import EgoState
from pedcross_env.world.pedestrians import PedestrianPoses
from pedcross_env.world.traffic import DrivingPoses, Traffic

__all__ = ["EGO_ID", "ActorRecords"]

EGO_ID = 1
_POSE_FIELDS = ("x", "y", "z", "yaw", "speed", "gait_phase", "gait_stride", "head_yaw")


class ActorRecords:
    """Fills ACTOR_DTYPE records. Ids: ego 1, then the scenario's vehicles, its pedestrians, and doors of parked cars.

    Args:
        scenario: Who is there.
        ego: The ego's size.
        traffic: Which of the vehicles drive, and the doors of those that do not.
        headlights: Whether the vehicles that drive have their low beams on, the ego too unless its config says more.

    Attributes:
        pedestrian_ids: (P,) int, of the scenario's pedestrians in their order.
        vehicle_ids: (V + D,) int, of the scenario's vehicles, then of the doors.
    """

    def __init__(self, scenario: Scenario, ego: EgoConfig, traffic: Traffic, *, headlights: bool) -> None:
        vehicles, pedestrians = scenario.vehicles, scenario.pedestrians
        self._first_pedestrian = len(vehicles)
        self._first_door = len(vehicles) + len(pedestrians)
        self._movers = np.array(traffic.movers, dtype=np.int64)
        self._actors = np.zeros(self._first_door + len(traffic.doors), dtype=ACTOR_DTYPE)
        self._actors["id"] = np.arange(len(self._actors)) + EGO_ID + 1
        for record, spec in zip(self._actors, vehicles, strict=False):
            record["kind"], record["model"] = ActorKind.VEHICLE, VEHICLE_MODELS.index(spec.model)
            record["seed"], record["x"], record["y"], record["yaw"] = (
                spec.seed,
                spec.x_m,
                spec.y_m,
                spec.yaw_rad,
            )
            record["length"], record["width"], record["height"] = vehicle_size(spec.model)
        for record, owner in zip(self._actors[self._first_door :], traffic.doors.owners, strict=True):
            record["kind"], record["model"] = ActorKind.VEHICLE, VEHICLE_MODELS.index(DOOR_MODEL)
            car = vehicles[owner]  # whose paint it has
            record["seed"] = (VEHICLE_MODELS.index(car.model) << 32) + (car.seed & 0xFFFFFFFF)
            record["length"], record["width"], record["height"] = vehicle_size(DOOR_MODEL)
        people = self._actors[self._first_pedestrian : self._first_door]
        for record, person in zip(people, pedestrians, strict=True):
            record["kind"], record["model"] = ActorKind.PEDESTRIAN, PEDESTRIAN_MODELS.index(person.model)
            record["seed"], record["accessory"] = person.seed, ACCESSORIES.index(person.accessory)
            record["length"], record["width"], record["height"] = pedestrian_size(person.height_m)
        self._actors["headlight"][self._movers] = float(headlights)
        self._ego = np.zeros((), dtype=ACTOR_DTYPE)
        self._ego["id"], self._ego["kind"], self._ego["model"] = (
            EGO_ID,
            ActorKind.VEHICLE,
            VEHICLE_MODELS.index("sedan"),
        )
        own = {"auto": float(headlights), "low": 1.0, "high": 2.0}[ego.headlights]
        self._ego["headlight"] = own
        self._ego["length"], self._ego["width"], self._ego["height"] = ego.length_m, ego.width_m, ego.height_m
        ids = self._actors["id"]
        self.vehicle_ids = np.concatenate([ids[: self._first_pedestrian], ids[self._first_door :]])
        self.pedestrian_ids = ids[self._first_pedestrian : self._first_door].copy()

    def ego(self, state: EgoState, pose: tuple[float, float, float]) -> np.ndarray:
        """The ego's record, 0-d; ``pose`` is (x, y, heading)."""
        record = self._ego.copy()
        record["x"], record["y"], record["yaw"] = pose
        record["speed"] = state.speed_mps
        record["pitch"], record["brake_light"] = state.pitch_rad, state.brake_light
        return record

    def actors(
        self, driving: Sequence[DrivingPoses], people: PedestrianPoses, doors: Sequence[np.ndarray]
    ) -> np.ndarray:
        """(T, N) records of all others at T moments.

        Args:
            driving: (T,) poses of the vehicles that drive.
            people: (T, P) poses of all pedestrians.
            doors: (T,) of (D, 3) x, y, heading.
        """
        records = np.tile(self._actors, (len(driving), 1))
        if self._movers.size:
            poses = np.array(driving)
            for index, field in enumerate(DrivingPoses._fields):
                records[field][:, self._movers] = poses[:, index]
        walking = records[:, self._first_pedestrian : self._first_door]
        for field in _POSE_FIELDS:
            walking[field] = getattr(people, field)
        if self._first_door < records.shape[1]:
            places = np.array(doors)
            for index, field in enumerate(("x", "y", "yaw")):
                records[field][:, self._first_door :] = places[..., index]
        return records

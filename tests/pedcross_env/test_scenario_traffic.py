"""Vehicles of random crossings keep clear of one another, whatever the ego does."""

import numpy as np
import pytest

from pedcross_env.config import BehaviourConfig, EgoConfig, LabelConfig, TrafficConfig, WorldConfig
from pedcross_env.contracts import Outcome
from pedcross_env.scenario.footprints import box_gaps_m
from pedcross_env.scenario.sampler import sample_crossing
from pedcross_env.world import World

EGO = EgoConfig()
SLACK_M = 0.01


def gaps_m(actors: np.ndarray) -> np.ndarray:
    """(V, V) separations of all pairs of boxes, 0 or less in contact."""
    one, other = actors[:, None], actors[None, :]
    cos, sin = np.cos(one["yaw"]), np.sin(one["yaw"])
    dx, dy = other["x"] - one["x"], other["y"] - one["y"]
    return np.stack(
        [
            box_gaps_m(
                (dx * cos + dy * sin)[i], (dy * cos - dx * sin)[i], (actors[i]["length"], actors[i]["width"]),
                actors["length"], actors["width"], actors["yaw"] - actors[i]["yaw"],
            )
            for i in range(len(actors))
        ]
    )  # fmt: skip


def overlaps(seed: int, traffic: TrafficConfig, *, brakes: bool) -> list[tuple[float, int, int]]:
    """(time, one, other) of vehicles, doors included, of which one moves and that touch."""
    scenario = sample_crossing(seed, traffic, EGO)
    world = World(scenario, ego=EGO, world=WorldConfig(), label=LabelConfig(), friction=0.85)
    people, found = len(scenario.pedestrians), []
    while world.outcome is Outcome.RUNNING:
        facts = world.facts()
        slow = facts["speed_mps"] < scenario.ego_speed_mps - 0.1
        wanted = -9.0 if facts["crossing"] or facts["conflict"] else 3.0 * slow
        world.step(wanted if brakes else 0.0)
        actors = world.snapshot(world.time_s).actors
        first = len(scenario.vehicles)
        vehicles = np.concatenate([actors[:first], actors[first + people :]])
        touching = (gaps_m(vehicles) < -SLACK_M) & ~np.eye(len(vehicles), dtype=bool)
        touching &= (vehicles["speed"] > 0.05)[:, None]
        found += [(world.time_s, int(i), int(j)) for i, j in zip(*np.nonzero(touching), strict=True)]
    return found


@pytest.mark.parametrize("brakes", [False, True])
@pytest.mark.parametrize("street", [{}, {"intersection": 1.0}, {"curve": 1.0}])
def test_no_vehicle_drives_through_another_or_through_a_door(street: dict[str, float], brakes: bool) -> None:
    how = BehaviourConfig(cyclist=0.8, door=0.5, leader=0.4, **street)
    for seed in (*range(12), 18, 27, 29, 46, 61, 70, 71, 72, 77):
        assert overlaps(seed, TrafficConfig(behaviour=how), brakes=brakes) == [], seed


def test_overlaps_are_found_where_there_are_some() -> None:
    box = np.zeros(3, dtype=[(n, float) for n in ("x", "y", "yaw", "length", "width", "speed")])
    box["length"], box["width"], box["x"] = 4.0, 2.0, (0.0, 3.0, 20.0)
    assert gaps_m(box)[0, 1] == pytest.approx(-1.0)
    assert gaps_m(box)[0, 2] == pytest.approx(16.0)

"""Strategies for any configuration and any scenario, allowed or absurd, which the tests of that name share."""

import math
import os

from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

from pedcross_env.scenario import (
    ACCESSORIES,
    VEHICLE_MODELS,
    Intersection,
    Leg,
    Maneuver,
    PedestrianSpec,
    Scenario,
    StreetSpec,
    Trigger,
    VehicleSpec,
)

EXAMPLES = int(os.environ.get("PEDCROSS_CONFIGS", "200"))
many = settings(
    max_examples=EXAMPLES,
    deadline=None,
    derandomize=EXAMPLES <= 1000,
    suppress_health_check=list(HealthCheck),
)
ODD = st.sampled_from([math.nan, math.inf, -math.inf, -1.0, 0.0, 1e-9, 1e-200, 1e9, -7, 10**6, -0.0])


def number(low: float, high: float) -> st.SearchStrategy:
    return st.floats(low, high, allow_subnormal=False)


@st.composite
def spoilt(draw, strategy, odd=ODD):
    """A mapping in which one number in three cases is an absurd one."""
    drawn = draw(strategy)
    if draw(st.integers(0, 2)) > 0:
        return drawn
    numbers = [(holder, key) for holder, key, value in leaves(drawn) if type(value) in (int, float)]
    if numbers:
        holder, key = draw(st.sampled_from(numbers))
        holder[key] = draw(odd)
    return drawn


def leaves(holder):
    """(mapping or list, key or index, value) of everything that is neither."""
    for key, value in holder.items() if isinstance(holder, dict) else enumerate(holder):
        if isinstance(value, (dict, list)):
            yield from leaves(value)
        else:
            yield holder, key, value


def some(**fields: st.SearchStrategy) -> st.SearchStrategy:
    """A mapping with any of the fields."""
    return st.fixed_dictionaries({}, optional=fields)


share = number(0.0, 0.2)
BEHAVIOUR = some(
    hesitates=share, stops_midway=share, turns_back=share, yields=share, both_sides=share,
    yields_midway=share, curve=number(0, 1), cyclist=number(0, 1), door=number(0, 1), intersection=number(0, 1),
    leader=number(0, 1),
    group_sizes=st.lists(number(0.0, 1.0), min_size=4, max_size=4), along_kerb=number(0, 2),
)  # fmt: skip
TRAFFIC = st.fixed_dictionaries(
    {"duration_s": number(1.0, 4.0)},
    optional={
        "crossing_share": number(0, 1), "max_bystanders": st.integers(0, 6), "max_oncoming": st.integers(0, 4),
        "parked_share": number(0, 1), "behaviour": BEHAVIOUR,
        "ego_speed_mps": st.tuples(number(0.5, 10.0), number(10.0, 40.0)).map(list),
    },
)  # fmt: skip
EGO = some(
    length_m=number(2.8, 12.0), width_m=number(0.5, 2.6), height_m=number(1.0, 4.0), latency_s=number(0, 1),
    max_acceleration_mps2=number(0.1, 8.0), max_deceleration_mps2=number(0.1, 12.0), jerk_mps3=number(1.0, 100.0),
    build_up_s=number(0, 1), abs=st.booleans(), steering=st.booleans(), steer_rate_radps=number(0.1, 3.0),
)  # fmt: skip
CLOCK = st.sampled_from(
    [(30, 120), (5, 5), (10, 100), (60, 120), (7, 21), (30, 60), (1, 1), (240, 240), (30, 100)]
)
CONFIG = st.fixed_dictionaries(
    {"traffic": TRAFFIC, "modalities": st.just(())},
    optional={
        "ego": EGO, "world": CLOCK.map(lambda c: {"policy_hz": c[0], "tick_hz": c[1]}),
        "label": some(range_m=number(1, 100), conflict_horizon_s=number(0.1, 8.0), conflict_margin_m=number(0, 2)),
        "reward": some(collision=number(0, 9), proximity=number(0, 9), jerk_per_mps3=number(0, 1)),
        "weather": st.lists(st.sampled_from(["clear", "rain", "fog", "night", "ice"]), min_size=1, max_size=2),
        "actions": st.sampled_from(["continuous", "discrete"]),
        "demand_levels": st.lists(number(-1, 1), min_size=1, max_size=4),
    },
)  # fmt: skip

TRIGGER = st.one_of(
    number(0, 4).map(lambda v: {"time_s": v}), number(0, 60).map(lambda v: {"distance_m": v}),
    number(0, 6).map(lambda v: {"ttc_s": v}), number(0, 6).map(lambda v: {"gap_s": v, "delay_s": 0.3}),
    number(0, 20).map(lambda v: {"ego_below_mps": v}), number(0, 90).map(lambda v: {"reached_x_m": v}),
)  # fmt: skip
LEG = st.fixed_dictionaries(
    {"to_x_m": number(0, 90), "to_y_m": number(-9, 9), "speed_mps": number(0.3, 4.0)},
    optional={"wait_s": number(0, 3), "go": TRIGGER},
)
PERSON = st.fixed_dictionaries(
    {"x_m": number(0, 90), "y_m": number(-8, 8), "legs": st.lists(LEG, max_size=3)},
    optional={
        "height_m": number(0.8, 2.1),
        "model": st.sampled_from(["adult", "child", "elderly"]),
        "accessory": st.sampled_from(ACCESSORIES),
        "seed": st.integers(0, 2**62),
        "yaw_rad": number(-4, 4),
    },
)
LANE_Y = st.sampled_from([-5.25, -1.75, 1.75, 5.25, 0.0, -7.8, 8.0, -1.2])
VEHICLE = st.fixed_dictionaries(
    {"x_m": number(-30, 120), "y_m": st.one_of(LANE_Y, number(-8, 8)), "speed_mps": number(0, 15)},
    optional={
        "yaw_rad": st.sampled_from([0.0, math.pi, math.pi / 2, -math.pi / 2, 0.3]), "parked": st.booleans(),
        "turn": st.sampled_from(["left", "right", "straight", ""]), "door": TRIGGER, "yields": st.booleans(),
        "model": st.sampled_from(VEHICLE_MODELS),
        "seed": st.integers(0, 2**62),
        "maneuver": st.fixed_dictionaries(
            {"when": TRIGGER, "speed_mps": number(0, 20)}, optional={"to_y_m": number(-6, 6)}
        ),
    },
)  # fmt: skip
STREET = some(
    lane_width_m=number(2.5, 5.0), lanes_per_direction=st.integers(1, 3), parking_width_m=number(0, 4),
    crossing=number(40.0, 160.0), curve_start_x_m=number(10.0, 80.0),
    curvature_per_m=number(1e-6, 0.02) | number(-0.02, -1e-6),
)  # fmt: skip
SCENARIO = st.fixed_dictionaries(
    {
        "street": STREET, "people": st.lists(PERSON, max_size=4), "vehicles": st.lists(VEHICLE, max_size=4),
        "ego_speed_mps": number(0, 20), "duration_s": number(0.5, 3.0), "finish_x_m": number(10, 150),
    },
    optional={"ego_turn": st.sampled_from(["straight", "left", "right"])},
)  # fmt: skip


def trigger(values):
    return None if values is None else Trigger(**values)


def scenario(values) -> Scenario:
    """Build a scenario from drawn mappings."""
    street = dict(values["street"])
    if "crossing" in street:
        street["intersection"] = Intersection(x_m=street.pop("crossing"))
    people = [
        PedestrianSpec(
            **person | {"behaviour": "any",
                        "legs": tuple(Leg(**leg | {"go": trigger(leg.get("go"))}) for leg in person["legs"])}
        )
        for person in values["people"]
    ]  # fmt: skip
    vehicles = []
    for drawn in values["vehicles"]:
        spec = dict(drawn) | {"door": trigger(drawn.get("door"))}
        if "maneuver" in spec:
            doing = spec.pop("maneuver")
            spec["maneuvers"] = (Maneuver(**doing | {"when": trigger(doing["when"])}),)
        if spec.get("parked"):
            spec.pop("maneuvers", None)
            spec["speed_mps"] = 0.0
        else:
            spec["door"] = None
        vehicles.append(VehicleSpec(**spec))
    rest = {k: v for k, v in values.items() if k not in ("street", "people", "vehicles")}
    return Scenario(
        name="any", street=StreetSpec(**street), pedestrians=tuple(people), vehicles=tuple(vehicles), **rest
    )

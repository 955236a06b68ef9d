"""Suites: every cell hits where and as fast as it says; what cannot be is refused by name."""

import dataclasses
import math
import re
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from hypothesis import given, settings
from hypothesis import strategies as st
from stable_baselines3.common.env_checker import check_env as sb3_check_env

from pedcross_env.camera import Renderer
from pedcross_env.config import CameraConfig, EgoConfig, LabelConfig, WorldConfig
from pedcross_env.contracts import Outcome
from pedcross_env.errors import ConfigError
from pedcross_env.scenario import Scenario
from pedcross_env.scenario.suites import SUITES, Cell, Goal, Provenance, Suite, register_suite, suite
from pedcross_env.weather import weather_by_name
from pedcross_env.world import World

OWN = Provenance(document="test", clause="none", certainty="own")
SMALL = {"camera": {"width_px": 64, "height_px": 48}}


def build(scenario: Scenario, ego: EgoConfig | None = None, policy_hz: int = 2, **world: object) -> World:
    clock = WorldConfig(policy_hz=policy_hz, tick_hz=60)
    return World(scenario, ego=ego or EgoConfig(), world=clock, label=LabelConfig(), friction=0.85, **world)


def never_braking(scenario: Scenario, ego: EgoConfig | None = None) -> World:
    world = build(scenario, ego)
    while world.outcome is Outcome.RUNNING:
        world.step(0.0)
    return world


def impact_share(world: World, width_m: float) -> float:
    """Place of the pedestrian's middle on the ego's width at the contact, 0 on its right side."""
    shot = world.snapshot(world.contact_time_s)
    hit = shot.actors[shot.actors["id"] == world.collided_with][0]
    assert hit["kind"] == 2, "hit a vehicle"
    dx, dy, yaw = float(hit["x"] - shot.ego["x"]), float(hit["y"] - shot.ego["y"]), float(shot.ego["yaw"])
    ahead = dx * math.cos(yaw) + dy * math.sin(yaw)
    assert ahead > 2.25, "hit by the side, not by the front"
    return 0.5 + (dy * math.cos(yaw) - dx * math.sin(yaw)) / width_m


@pytest.mark.parametrize("name", SUITES)
def test_who_never_brakes_hits_every_cell_where_and_as_fast_as_it_says(name: str) -> None:
    done: dict[Scenario, tuple[Outcome, float, float]] = {}
    for cell in suite(name).cells:
        scenario = dataclasses.replace(
            cell.scenario(), name=""
        )  # the same crossing in another light runs once
        if scenario not in done:
            world = never_braking(scenario)
            share = impact_share(world, 1.8) if world.outcome is Outcome.COLLISION else math.nan
            done[scenario] = world.outcome, share, world.impact_speed_mps
        outcome, share, speed = done[scenario]
        if not cell.hits:
            assert outcome is Outcome.PASSED, cell.id
            continue
        assert outcome is Outcome.COLLISION, cell.id
        assert abs(share - cell.impact_share) * 1.8 < 0.05, (cell.id, share)
        assert speed == pytest.approx(cell.ego_kmh / 3.6, abs=1e-9), cell.id


def test_the_timing_follows_the_egos_size() -> None:
    ego = EgoConfig(length_m=5.2, width_m=2.05)
    for cell_id in ("CPNA-25/40", "CPFA-90/20", "CPTAfs-50/15", "CPLA-25/40", "CPNA-75/30/heading+20"):
        cell = suite("euro-ncap-2026").cell(cell_id)
        world = never_braking(cell.scenario(ego), ego)
        assert impact_share(world, 2.05) == pytest.approx(cell.impact_share, abs=0.01), cell_id


def test_pedestrians_walk_as_stated() -> None:
    """Run-up and speed of CPFA-50, read off the positions."""
    world = build(suite("euro-ncap-2026").cell("CPFA-50/40").scenario(), policy_hz=60)
    places = []
    while world.outcome is Outcome.RUNNING:
        places.append(float(world.snapshot(world.time_s).actors[0]["y"]))
        world.step(0.0)
    y = np.array(places)
    assert y[0] - world.scenario.street.ego_lane_y_m == pytest.approx(6.0)
    speed = -np.diff(y) * 60
    assert speed[-1] == pytest.approx(8 / 3.6)
    first_even = int(np.argmax(speed > 8 / 3.6 - 1e-6))
    assert y[0] - y[first_even] == pytest.approx(1.5, abs=0.04)


@pytest.mark.parametrize(
    ("name", "cell_id"),
    [
        ("euro-ncap-2026", "CPNCO-50/40"),
        ("fmvss-127", "PED-OBSTRUCTED-50/50"),
        ("scenario-runner", "DynamicObjectCrossing-50/40"),
        ("scenario-runner", "ParkingCrossingPedestrian-50/30"),
    ],
)
def test_obstructed_pedestrians_are_hidden_before_they_are_seen(name: str, cell_id: str) -> None:
    cell, camera = suite(name).cell(cell_id), CameraConfig(width_px=192, height_px=108)
    renderer = Renderer(camera)
    world = build(cell.scenario(), policy_hz=4, camera=camera)
    renderer.load(world.scenario.street, weather_by_name(cell.weather))
    person = int(world._records.pedestrian_ids[0])
    shares = []
    while world.outcome is Outcome.RUNNING:
        shot = world.snapshot(world.time_s)
        shares.append(renderer.visible_fraction(renderer.render(shot), shot, person))
        world.step(0.0)
    shares = [0.0 if math.isnan(share) else share for share in shares]
    assert max(shares[: len(shares) // 2]) < 0.25, shares
    assert max(shares[-3:]) > 0.8, shares


@pytest.mark.parametrize("name", SUITES)
def test_every_cell_says_where_it_comes_from(name: str) -> None:
    own = suite(name)
    assert own.name == name
    assert own.version
    assert own.simplified
    for cell in own.cells:
        assert cell.provenance.document
        assert cell.provenance.clause
        assert re.fullmatch(r"[A-Za-z]+(-[a-zA-Z]+)*(-\d+)?/\d+(/[\w+-]+)*", cell.id), cell.id
        weather_by_name(cell.weather)


def test_the_tables_are_the_sources() -> None:
    """Spot checks of what the reference states: rows, speeds, limits."""
    ids = {name: {cell.id: cell for cell in suite(name).cells} for name in SUITES}
    ncap = ids["euro-ncap-2026"]
    assert {"CPFA-10/60", "CPNA-90/10", "CPNCO-75/30", "CPLA-10/60", "CPLA-25/80/warning", "CPNA-75/40/night",
            "CPNCO-50/20/ped+3", "CPTAfo-50/20", "CPTAns-50/10", "CPTAno-90/10", "CPTAfs-50/25", "CPNCO-75/60/night",
            "CPTAfs-50/10/ped+3", "CPNA-75/20/ped3/night"} <= set(ncap)  # fmt: skip
    assert ncap["CPFA-50/40"].pedestrian_kmh == 8
    assert ncap["CPNCO-50/40"].child
    assert ncap["CPNCO-50/40"].obstructed
    assert {cell.turn_radius_m for cell in ncap.values() if cell.turn} == {8.0, 9.0, 11.75, 14.75}
    fmvss = ids["fmvss-127"]
    assert "PED-OBSTRUCTED-50/60" not in fmvss
    assert fmvss["PED-STANDING-25/55/high"].headlights == "high"
    assert "PED-RIGHT-25/40/low" not in fmvss
    assert all(cell.ttc_s == 4.0 and cell.strict for cell in fmvss.values() if cell.kind == "crossing")
    r152 = ids["un-r152"]
    assert {i: cell.goal.limit for i, cell in r152.items() if i in ("PED-50/35", "PED-50/60", "PED-50/42/01")} == {
        "PED-50/35": 20, "PED-50/60": 45, "PED-50/42/01": 10,
    }  # fmt: skip
    assert r152["PED-50/40/01"].goal.kind == "no-contact"
    matrix = ids["weather-matrix"]
    assert len(matrix) == len({c.weather for c in matrix.values()}) * len(
        {i.rsplit("/", 1)[0] for i in matrix}
    )


def test_a_seed_changes_looks_alone() -> None:
    cell = suite("euro-ncap-2026").cell("CPNCO-50/40")
    one, two = cell.scenario(seed=1), cell.scenario(seed=2)
    assert one != two
    assert one.street.seed != two.street.seed
    for a, b in zip(one.pedestrians + one.vehicles, two.pedestrians + two.vehicles, strict=True):
        assert dataclasses.replace(a, seed=0) == dataclasses.replace(b, seed=0)


def test_the_environment_plays_a_cell() -> None:
    env = gymnasium.make("pedcross/Suite-v0", suite="fmvss-127", cell="PED-STANDING-25/50/high", config=SMALL)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*not normalized.*")
        check_env(env.unwrapped, skip_render_check=True)
        sb3_check_env(env.unwrapped)
    _, info = env.reset(seed=1)
    assert info["scenario"] == "PED-STANDING-25/50/high"
    assert info["weather"] == "night_unlit"
    assert info["speed_mps"] == pytest.approx(50 / 3.6)
    assert float(env.unwrapped.world.snapshot(0.0).ego["headlight"]) == 2.0
    _, info = env.reset(seed=1, options={"cell": "PED-RIGHT-25/30", "weather": "fog"})
    assert (info["scenario"], info["weather"]) == ("PED-RIGHT-25/30", "fog")
    _, info = env.reset(seed=1)
    assert info["scenario"] == "PED-STANDING-25/50/high"


def test_without_a_cell_seeds_go_through_the_suite() -> None:
    env = gymnasium.make("pedcross/Suite-v0", suite="un-r152", config={"modalities": ()})
    names = [env.reset(seed=seed)[1]["scenario"] for seed in range(39)]
    assert names[:38] == [cell.id for cell in suite("un-r152").cells]
    assert names[38] == names[0]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: suite("euro-ncap"), "Did you mean 'euro-ncap-2026'"),
        (lambda: suite("un-r152").cell("PED-50/61"), "Did you mean 'PED-50/60'"),
        (lambda: suite("euro-ncap-2026").cell("cpnco-50/40"), "Did you mean 'CPNCO-50/40'"),
        (lambda: gymnasium.make("pedcross/Suite-v0", suite="fmvs-127"), "'fmvss-127'"),
        (
            lambda: gymnasium.make("pedcross/Suite-v0", suite="fmvss-127", cell="x"),
            "pedcross suites fmvss-127",
        ),
        (lambda: Cell(id="a/1", kind="crossing", ego_kmh=-5, provenance=OWN), r"ego_kmh = -5 .*e.g. 40"),
        (
            lambda: Cell(id="a/1", kind="crossing", ego_kmh=5, pedestrian_kmh=0, provenance=OWN),
            "pedestrian_kmh = 0",
        ),
        (lambda: Cell(id="a/1", kind="crosing", ego_kmh=5, provenance=OWN), "'crossing'"),
        (
            lambda: Cell(id="a/1", kind="crossing", ego_kmh=5, impact_share=1.2, provenance=OWN),
            "impact_share = 1.2",
        ),
        (lambda: Cell(id="a/1", kind="along", ego_kmh=5, provenance=OWN), "could not reach"),
        (lambda: Provenance(document="a", clause="b", certainty="sure"), "certainty 'sure'"),
    ],
)
def test_what_is_unknown_or_impossible_is_refused_by_name(make, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        make()


def test_impossible_timing_says_what_would_do() -> None:
    slow = Cell(id="a/40", kind="crossing", ego_kmh=40, pedestrian_kmh=2, strict=True, provenance=OWN)
    with pytest.raises(ConfigError, match=r"ttc_s = 4 is impossible.* needs 9.10 s .*ttc_s = 9.1 or more"):
        slow.scenario()
    loose = dataclasses.replace(slow, strict=False)
    assert impact_share(never_braking(loose.scenario()), 1.8) == pytest.approx(0.5, abs=0.01)
    late = dataclasses.replace(slow, trigger_s=0.4)
    with pytest.raises(ConfigError, match=r"trigger_s = 0\.4 is impossible"):
        late.scenario()


def test_a_suite_of_ones_own() -> None:
    cell = Cell(id="MINE-50/30", kind="crossing", ego_kmh=30, goal=Goal(kind="no-contact"), provenance=OWN)
    facts = {"version": "1", "title": "t", "source": "s", "simplified": ("none",)}
    mine = Suite(name="mine", cells=(cell,), **facts)
    register_suite(mine)
    env = gymnasium.make("pedcross/Suite-v0", suite="mine", cell="MINE-50/30", config={"modalities": ()})
    assert env.reset(seed=0)[1]["scenario"] == "MINE-50/30"
    with pytest.raises(ConfigError, match="no other suite"):
        register_suite(dataclasses.replace(mine, name="un-r152"))
    with pytest.raises(ConfigError, match="MINE-50/30"):
        Suite(name="twice", cells=(cell, cell), **facts)


KINDS = ("crossing", "crossing", "group", "along", "standing", "gap", "plate")
any_cell = st.builds(
    Cell, id=st.just("ANY-50/1"), provenance=st.just(OWN), kind=st.sampled_from(KINDS),
    ego_kmh=st.floats(5, 90), pedestrian_kmh=st.floats(1, 16), impact_share=st.floats(0.1, 0.9),
    far_side=st.booleans(), child=st.booleans(), obstructed=st.booleans(), start_m=st.floats(2.5, 6.0),
    run_up_m=st.sampled_from([0.0, 0.5, 1.0, 1.5]), turn=st.sampled_from(["", "", "left", "right"]),
    turn_radius_m=st.floats(6.5, 14.0), ttc_s=st.floats(2.0, 8.0), strict=st.booleans(),
    trigger_s=st.sampled_from([0.0, 0.0, 1.5, 3.0]),
)  # fmt: skip


@settings(max_examples=150, deadline=None, derandomize=True)
@given(st.data())
def test_any_cell_is_refused_by_name_or_hits_where_it_says(data: st.DataObject) -> None:
    refused = ""
    try:
        cell = data.draw(any_cell)
        scenario = cell.scenario()
    except ConfigError as error:
        refused = str(error)
    if refused:
        assert re.match(r"Cell\('ANY-50/1'\)\.\w+ = |Scenario\.pedestrians\[\d\] = ", refused)
        return
    world = never_braking(scenario)
    if not cell.hits:
        assert world.outcome is Outcome.PASSED
        return
    assert world.outcome is Outcome.COLLISION
    assert abs(impact_share(world, 1.8) - cell.impact_share) * 1.8 < 0.05
    assert world.impact_speed_mps == pytest.approx(cell.ego_mps, abs=1e-9)

"""Any camera and sensor shows any scenario in any weather without nan; absurd ones are refused by a ConfigError.

The suite tries a few dozen; for thousands, set PEDCROSS_CONFIGS=10000 and run this file alone.
"""

import numpy as np
from any_config import EXAMPLES, SCENARIO, number, scenario, some, spoilt
from hypothesis import HealthCheck, event, given, reject, settings
from hypothesis import strategies as st

from pedcross_env.env import CrossingEnv
from pedcross_env.errors import ConfigError
from pedcross_env.scenario import Scenario
from pedcross_env.sensors.dvs_config import DVS_PRESETS
from pedcross_env.weather.presets import weather_names

STEPS = 3
CAMERA = st.fixed_dictionaries(
    {"width_px": st.integers(16, 72), "height_px": st.integers(16, 48)},
    optional={
        "horizontal_fov_deg": number(10, 150),
        "mount_x_m": number(-3, 4),
        "mount_y_m": number(-1, 1),
        "mount_z_m": number(0.3, 4),
        "yaw_deg": number(-180, 180),
        "pitch_deg": number(-45, 45),
        "roll_deg": number(-45, 45),
        "principal_point": st.lists(number(0.2, 0.8), min_size=2, max_size=2),
    },
)
RGB = some(
    exposure=st.sampled_from(["auto", "fixed"]),
    fixed_white_cd_m2=number(1, 1e5),
    adaptation_s=number(0, 2),
    full_well_e=number(50, 1e5),
    max_gain=number(1, 1e3),
    base_white_cd_m2=number(1, 1e4),
    longest_exposure_s=number(1e-4, 0.1),
    read_noise_e=number(0, 50),
    noise=st.booleans(),
    bloom=number(0, 1),
    motion_blur_samples=st.integers(1, 3),
)
DVS = st.fixed_dictionaries(
    {"max_subframes": st.integers(1, 4)},
    optional={
        "preset": st.sampled_from(sorted(DVS_PRESETS)),
        "positive_threshold": number(0.02, 2),
        "negative_threshold": number(0.02, 2),
        "sigma_threshold": number(0, 0.5),
        "refractory_ns": st.integers(0, 10**8),
        "cutoff_hz": number(0, 1e4),
        "leak_hz": number(0, 100),
        "shot_hz": number(0, 1e3),
        "hot_share": number(0, 0.5),
        "hot_hz": number(0, 1e3),
        "bus_events_per_s": number(1, 1e7),
        "bus_queue": st.integers(1, 1000),
        "log_floor_cd_m2": number(1e-4, 10),
        "max_flow_px": number(0.1, 10),
        "layers": st.booleans(),
    },
)
WEATHER = st.one_of(
    st.sampled_from(weather_names()),
    some(
        visibility_m=number(5, 1e4),
        rain_mm_h=number(0, 300),
        snow_mm_h=number(0, 50),
        snow_cover=number(0, 1),
        ice_cover=number(0, 1),
        lightning_per_min=number(0, 120),
        water_film_mm=number(0, 20),
        wetness=number(0, 1),
        cloudiness=number(0, 1),
        wind_mps=number(-60, 60),
        sun_altitude_deg=number(-90, 90),
        sun_azimuth_deg=number(-360, 360),
        street_lamps=st.booleans(),
        headlights=st.booleans(),
        tunnel_exit_m=number(-50, 150),
    ),
    some(
        cloudiness=number(0, 100),
        precipitation=number(0, 100),
        precipitation_deposits=number(0, 100),
        wind_intensity=number(0, 100),
        sun_altitude_angle=number(-90, 90),
        sun_azimuth_angle=number(-360, 360),
        fog_density=number(0, 100),
        fog_distance=number(0, 100),
        wetness=number(0, 100),
        dust_storm=number(0, 100),
    ).map(lambda values: {"carla": values}),
)
SIGHT = st.fixed_dictionaries(
    {"camera": CAMERA, "weather": st.lists(WEATHER, min_size=1, max_size=1), "return_events": st.just(True)},
    optional={
        "rgb": RGB,
        "dvs": DVS,
        "label_events": st.booleans(),
        "windscreen": some(drops=st.booleans(), wiper=st.sampled_from(["auto", "off"])),
    },
)


EXAMPLES_HERE = max(40, EXAMPLES // 5)
tried = settings(
    max_examples=EXAMPLES_HERE,
    deadline=None,
    derandomize=EXAMPLES <= 1000,
    suppress_health_check=list(HealthCheck),
)
shown: list[int] = []


def show(config, played: Scenario, seed: int) -> None:
    """Look at a scenario for some steps, watching for nan and for events out of their window."""
    env = CrossingEnv(config)
    observation, info = env.reset(seed=seed, options={"scenario": played})
    last_ns = 0
    for _ in range(STEPS):
        assert env.observation_space.contains(observation)
        observation, _, terminated, truncated, info = env.step(np.zeros(env.action_space.shape, np.float32))
        truth = env.truth(flow=True)
        assert (truth.depth > 0).all()
        assert truth.flow_px.shape == (*truth.depth.shape, 2)
        events = info["events"]
        times = events["t"]
        assert (np.diff(times) >= 0).all()
        assert times.size == 0 or last_ns <= times[0] <= times[-1] <= round(info["time_s"] * 1e9)
        last_ns = round(info["time_s"] * 1e9)
        assert (events["x"] < config["camera"]["width_px"]).all()
        assert (events["y"] < config["camera"]["height_px"]).all()
        if config.get("label_events"):
            assert len(info["event_causes"]) == len(events)
        if terminated or truncated:
            break


@tried
@given(config=SIGHT, drawn=SCENARIO, seed=st.integers(0, 2**32))
def show_what_is_allowed(config, drawn, seed):
    try:
        show(config, scenario(drawn), seed)
    except ConfigError:
        # does not count as an example: another is drawn
        reject()
    shown.append(seed)


def test_any_scenario_is_seen_by_any_camera_in_any_weather():
    shown.clear()
    show_what_is_allowed()
    assert len(shown) >= EXAMPLES_HERE / 2


@tried
@given(both=spoilt(st.fixed_dictionaries({"config": SIGHT, "drawn": SCENARIO})), seed=st.integers(0, 2**32))
def test_what_is_absurd_is_seen_or_refused(both, seed):
    try:
        show(both["config"], scenario(both["drawn"]), seed)
    except ConfigError as error:
        event(f"refused: {str(error)[:60]}")

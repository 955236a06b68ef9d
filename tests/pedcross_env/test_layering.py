"""The scene in layers by distance: the same picture as in one, each layer rendered as often as its motion asks for."""

import itertools

import numpy as np
import pytest
from camera_scenes import NIGHT, renderer, snapshot

from pedcross_env.camera import FARTHEST, NEAREST, Border, Layer, Renderer, Seen, camera_pose, compose
from pedcross_env.config import CameraConfig
from pedcross_env.contracts import ACTOR_DTYPE, Snapshot
from pedcross_env.env import CrossingEnv
from pedcross_env.errors import ConfigError
from pedcross_env.flow import layer_motion_px
from pedcross_env.layering import Cadence, Pictures, renders_of
from pedcross_env.parting import Parting
from pedcross_env.sensors.dvs_pictures import log_picture
from pedcross_env.weather import Weather

HOLD = np.zeros(1, np.float32)
STEP_S = 1 / 30
FAST = {"modalities": ("rgb",), "weather": ("clear",), "traffic": {"ego_speed_mps": (12.0, 12.0)}}


def street(seed: int) -> tuple[CrossingEnv, Renderer]:
    env = CrossingEnv(FAST)
    env.reset(seed=seed)
    made = Renderer(env.config.camera)
    made.load(env.world.scenario.street, Weather())
    return env, made


def last_step(env: CrossingEnv) -> tuple[Snapshot, Snapshot]:
    return env.world.snapshot(env.world.time_s - STEP_S), env.world.snapshot(env.world.time_s)


def parted(env: CrossingEnv, made: Renderer, instants: int = 30) -> list[Cadence]:
    return Parting(env.config.camera, made.surroundings).cadences(*last_step(env), instants, 1.0)


@pytest.mark.parametrize("seed", range(4))
def test_layers_put_together_are_the_whole_picture(seed: int) -> None:
    env, made = street(seed)
    for _ in range(3):
        for _ in range(8):
            env.step(HOLD)
        parts, now = parted(env, made), env.world.snapshot(env.world.time_s)
        assert len(parts) > 1
        seen = made.layers(made.moments([now])[0], [part.layer for part in parts])
        together = compose([(look, look, 0.0) for look in seen], (256, 450))
        whole = made.render(now, luminance_only=True).luminance
        apart = np.abs(np.log(together) - np.log(whole))
        # where houses of two layers meet, and at the horizon, where soft shadows are drawn by what is free
        assert (apart > 0.02).mean() < 2e-3
        assert (apart > 1e-4).mean() < 1e-2


@pytest.mark.parametrize("seed", range(4))
def test_nothing_beyond_a_plane_moves_by_more_than_the_bound(seed: int) -> None:
    env, made = street(seed)
    tightest = np.inf
    for step in range(16):
        env.step(HOLD)
        if step % 5:
            continue
        before, after = last_step(env)
        poses = camera_pose(env.config.camera, before.ego), camera_pose(env.config.camera, after.ego)
        planes = float(before.ego["x"]) + np.array([8.0, 18.0, 30.0, 45.0])
        truth = env.truth(flow=True)
        flow = np.hypot(*np.moveaxis(truth.flow_px, -1, 0))
        for plane, bound in zip(
            planes, layer_motion_px(poses, made.surroundings, before, after, planes), strict=True
        ):
            beyond = truth.depth > plane - poses[1].origin[0]
            most = np.nanmax(flow[beyond])
            assert most <= bound
            tightest = min(tightest, bound / most)
    assert tightest < 1.5


def test_a_standing_car_leaves_the_scene_whole_or_renders_what_is_far_seldom() -> None:
    env, made = street(1)
    env.step(HOLD)
    before, after = last_step(env)
    still = Snapshot(after.time_s, before.ego, after.actors)
    parting = Parting(env.config.camera, made.surroundings)
    parts = parting.cadences(before, still, 30, 1.0)
    assert parts[-1].stride >= 8
    turned = before.ego.copy()
    turned["yaw"] = 0.3
    parts = parting.cadences(Snapshot(0.0, turned, before.actors), after, 30, 1.0)
    assert len(parts) == 1
    assert parts[0].layer == Layer(NEAREST, FARTHEST, 256, 0, parts[0].layer.actors)
    assert parts[0].layer.actors.all()


@pytest.mark.parametrize("most_px", [1.0, 2.5])
def test_no_layer_moves_farther_between_two_renders_than_allowed(most_px: float) -> None:
    env, made = street(3)
    parting, strides = Parting(env.config.camera, made.surroundings), []
    for _ in range(20):
        env.step(HOLD)
        before, after = last_step(env)
        poses = camera_pose(env.config.camera, before.ego), camera_pose(env.config.camera, after.ego)
        _, *behind = parting.cadences(before, after, 10, most_px)
        places = np.array(parting.planes.places_m)
        motion = layer_motion_px(poses, made.surroundings, before, after, places)
        for part, px in zip(behind, motion, strict=True):
            assert part.stride == 1 or part.stride * px / 10 <= most_px
            strides.append(part.stride)
    assert max(strides) > 2


def test_planes_last_for_some_steps_and_stay_ahead() -> None:
    env, made = street(0)
    parting, chosen = Parting(env.config.camera, made.surroundings), []
    for _ in range(30):
        env.step(HOLD)
        before, after = last_step(env)
        parts = parting.cadences(before, after, 10, 2.5)
        assert len(parts) == len(parting.planes.places_m) + 1
        assert min(parting.planes.places_m) > camera_pose(env.config.camera, after.ego).origin[0] + 3.0
        chosen.append(parting.planes)
    changes = sum(old != new for old, new in itertools.pairwise(chosen))
    assert 1 <= changes <= 12
    going_on = Parting(env.config.camera, made.surroundings, chosen[-2])
    assert repr(going_on.cadences(before, after, 10, 2.5)) == repr(parts)


def test_every_actor_is_of_one_layer_and_layers_cover_the_street() -> None:
    env, made = street(2)
    for _ in range(5):
        env.step(HOLD)
    layers = [part.layer for part in parted(env, made)]
    assert np.sum([layer.actors for layer in layers], axis=0).tolist() == [1] * len(layers[0].actors)
    assert [layer.start for layer in layers[1:]] == [layer.end for layer in layers[:-1]]
    assert [layer.rows for layer in layers[1:]] == [layer.ground_row for layer in layers[:-1]]
    assert (layers[0].rows, layers[-1].ground_row) == (256, 0)


def test_borders_lie_between_roofs_on_either_side() -> None:
    _, made = street(3)
    around = made.surroundings
    for x in np.arange(0.0, 150.0, 7.0):
        border = around.border(float(x))
        assert isinstance(border, Border)
        for place, side in ((border.right_m, -1), (border.left_m, 1)):
            assert x <= place < x + 40.0
            roofs = around.roofs[around.roofs[:, 2] * side > 0]
            # no deeper in any roof than where the houses' walls have begun
            assert not ((roofs[:, 0] + 3.0 < place) & (place < roofs[:, 1])).any()


def test_pictures_run_straight_between_renders_of_each_layer() -> None:
    """A near layer over the lower half that jumps, a far one that brightens steadily and is rendered thrice."""
    asked: list[tuple[int, int]] = []
    near = Cadence(Layer(NEAREST, Border(9.0, 9.0), 4, 2, None), 1)
    far = Cadence(Layer(Border(9.0, 9.0), FARTHEST, 4, 0, None), 3)

    def look(instant: int, layer: Layer) -> Seen:
        asked.append((instant, layer.ground_row))
        if layer is far.layer:
            return Seen(np.full((4, 5), 10.0 + instant, np.float32), np.ones((4, 5), np.float32))
        cover = np.zeros((4, 5), np.float32)
        cover[2:] = 1.0
        cover[1] = 0.25
        return Seen(cover * np.float32(100 * (instant % 2)), cover)

    def render(instant: int, layers: list[Layer], *, passing: bool) -> list[Seen]:
        if passing:
            np.copyto(passed.luminance, look(instant, layers[0]).luminance)
            return [passed]
        return [look(instant, layer) for layer in layers]

    passed = look(0, near.layer)
    pictures = Pictures([near, far], [look(0, far.layer)], 8, render)
    seen = [log_picture(picture, (4, 5), 0.5) for picture in pictures]
    assert sorted(instant for instant, row in asked if row == 2) == [0, 1, 2, 3, 4, 5, 6, 7, 8]
    assert [instant for instant, row in asked if row == 0] == [0, 3, 6, 8]
    assert pictures.far[0].luminance[0, 0] == 18.0
    assert renders_of([near, far], 8) == 11
    for instant, picture in enumerate(seen, 1):
        light = np.exp(picture) - 0.5
        np.testing.assert_allclose(light[0], 10.0 + instant, rtol=1e-6)
        np.testing.assert_allclose(light[1], 25.0 * (instant % 2) + 0.75 * (10.0 + instant), rtol=1e-6)
        np.testing.assert_allclose(light[3], 100.0 * (instant % 2), rtol=1e-6)


def test_each_layer_is_rendered_once_at_an_instant_and_what_is_behind_comes_first() -> None:
    layers = [Layer(NEAREST, FARTHEST, 4, row, None) for row in (3, 2, 1, 0)]
    parts = [Cadence(layer, stride) for layer, stride in zip(layers, (1, 2, 3, 6), strict=True)]
    asked: list[tuple[int, int]] = []

    def render(instant: int, wanted: list[Layer], *, passing: bool) -> list[Seen]:
        assert not passing or len(wanted) == 1
        asked.extend((3 - layer.ground_row, instant) for layer in wanted)
        return [Seen(*np.zeros((2, 4, 5), np.float32)) for _ in wanted]

    for shown, _ in enumerate(Pictures(parts, render(0, layers[1:], passing=False), 10, render), 1):
        for k, part in enumerate(parts):
            assert max(instant for layer, instant in asked if layer == k) >= shown
            assert max(instant for layer, instant in asked if layer == k) < shown + 6, part
    expected = {k: {*range(0, 10, part.stride), 10} for k, part in enumerate(parts)}
    expected[0].remove(0)
    assert sorted(asked) == sorted((k, instant) for k, instants in expected.items() for instant in instants)
    assert renders_of(parts, 10) == len(asked) - 3  # those at the start are of the step before


@pytest.mark.parametrize(
    "weather", [NIGHT, Weather(wetness=0.3), Weather(sun_altitude_deg=6.0, sun_azimuth_deg=0.0)]
)
def test_layers_are_refused_where_light_reaches_other_parts(weather: Weather) -> None:
    camera, scene = renderer(weather, width_px=112, height_px=64), snapshot()
    assert not camera.by_layers(scene.ego)
    with pytest.raises(ConfigError, match="call render"):
        camera.moments([scene])


def test_a_lens_that_bends_has_no_layers() -> None:
    bent = renderer(Weather(), lens="brown", distortion=(-0.2, 0.05), width_px=112, height_px=64)
    assert not bent.by_layers(snapshot().ego)
    assert not Renderer(CameraConfig()).by_layers(np.zeros((), ACTOR_DTYPE))  # nothing is loaded


def test_events_of_layers_are_nearly_those_of_the_whole_scene() -> None:
    counts = {}
    for layers in (True, False):
        env = CrossingEnv(
            {"modalities": ("dvs",), "weather": ("clear",), "traffic": {"ego_speed_mps": (10.0, 10.0)},
             "dvs": {"layers": layers, "max_subframes": None, "shot_hz": 0.0}}
        )  # fmt: skip
        env.reset(seed=1)
        seen = []
        for _ in range(6):
            observation, *_, info = env.step(HOLD)
            seen.append(observation["dvs"].astype(np.int64))
            assert (info["renders"] > info["subframes"]) == layers
        counts[layers] = np.array(seen)
    signed = {layers: found[..., 0] - found[..., 1] for layers, found in counts.items()}
    assert counts[True].sum() == pytest.approx(counts[False].sum(), rel=0.02)
    assert np.abs(signed[True] - signed[False]).sum() < 0.1 * np.abs(signed[False]).sum()


def test_a_kept_moment_goes_on_bit_for_bit_with_layers() -> None:
    """What is far is taken over from step to step; who comes back to a moment renders it again."""
    env = CrossingEnv({"modalities": ("dvs",), "weather": ("clear",), "dvs": {"max_subframes": None}})
    env.reset(seed=1)
    for _ in range(3):
        env.step(HOLD)
    kept = env.save_state()

    def go_on(played: CrossingEnv) -> list[bytes]:
        found = []
        for _ in range(8):
            observation, *_, info = played.step(HOLD)
            assert info["renders"] > info["subframes"]
            found.append(observation["dvs"].tobytes())
        return found

    first = go_on(env)
    env.load_state(kept)
    assert go_on(env) == first
    other = CrossingEnv({"modalities": ("dvs",), "weather": ("clear",), "dvs": {"max_subframes": None}})
    other.reset(seed=5)
    other.load_state(kept)
    assert go_on(other) == first


def test_labels_and_rain_see_the_whole_scene() -> None:
    for more in (
        {"weather": ("rain",)},
        {"return_events": True, "label_events": True, "weather": ("clear",)},
    ):
        env = CrossingEnv({"modalities": ("dvs",), "camera": {"width_px": 112, "height_px": 64}} | more)
        env.reset(seed=1)
        *_, info = env.step(HOLD)
        assert info["renders"] == info["subframes"] > 1

"""Curves, intersections and turned cameras against analytic geometry and against the kernel for straight streets."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from camera_scenes import NIGHT, STREET, pedestrian, snapshot, vehicle
from scipy import ndimage

from pedcross_env.camera import Renderer, camera_pose, project
from pedcross_env.config import CameraConfig
from pedcross_env.contracts import ACTOR_DTYPE, Snapshot, StaticClass
from pedcross_env.scenario.layout import to_street, to_world, turning_path
from pedcross_env.scenario.street import Crosswalk, Intersection, StreetSpec
from pedcross_env.weather.weather import Weather

CURVED = StreetSpec(
    crosswalks=(Crosswalk(x_m=40.0),),
    seed=5,
    curvature_per_m=1 / 45,
    curve_start_x_m=20.0,
    curve_length_m=70.0,
)
OVERCAST = Weather(cloudiness=1.0)  # no shade on the paint
DRY_NIGHT = replace(NIGHT, wetness=0.0)
CROSSED = StreetSpec(intersection=Intersection(x_m=60.0), seed=5)


def ego_at(x, y, yaw, *actors):
    return Snapshot(0.0, vehicle(1, x, y, yaw=yaw), np.array(list(actors), ACTOR_DTYPE))


def camera_on(street, weather=None, **settings):
    camera = Renderer(CameraConfig(**settings))
    camera.load(street, weather or Weather(), free_heading=True)
    return camera


def ground_under(pose, u, v):
    """World x, y and depth where the ray through a pixel meets the road's plane."""
    ray = pose.rotation.T @ np.array([(u - pose.cx) / pose.focal_px, (v - pose.cy) / pose.focal_px, 1.0])
    depth = -pose.origin[2] / ray[2]
    return *(pose.origin + depth * ray)[:2], depth


@pytest.mark.parametrize(
    "weather",
    [Weather(), NIGHT, Weather(visibility_m=60.0), Weather(snow_cover=0.8)],
    ids=["day", "night", "fog", "snow"],
)
def test_a_straight_street_looks_the_same_by_either_kernel(weather):
    scene = snapshot(vehicle(4, 14, -4.6), pedestrian(5, 12, -1.0), vehicle(6, 30, 1.75, yaw=math.pi))
    by_rows = Renderer(CameraConfig())
    by_rows.load(STREET, weather)
    expected, frame = by_rows.render(scene), camera_on(STREET, weather).render(scene)
    white = np.percentile(expected.luminance, 99)
    assert np.abs(frame.luminance - expected.luminance).mean() < 0.006 * white
    np.testing.assert_array_equal(frame.instance, expected.instance)
    np.testing.assert_allclose(frame.depth, expected.depth, rtol=1e-5)


@pytest.mark.parametrize("yaw", [0.7, -1.6, 3.0])
def test_depth_of_the_ground_is_where_the_ray_meets_the_road(yaw):
    camera = camera_on(CROSSED, width_px=96, height_px=64, pitch_deg=4.0)
    scene = ego_at(60.0, 0.0, yaw)
    frame, pose = camera.render(scene), camera_pose(camera.config, scene.ego)
    rows, columns = np.nonzero(frame.instance == StaticClass.GROUND)
    assert len(rows) > 1000
    for row, column in list(zip(rows, columns, strict=True))[::97]:
        expected = ground_under(pose, column + 0.5, row + 0.5)[2]
        assert frame.depth[row, column] == pytest.approx(expected, rel=1e-4)


def _white(frame):
    """Luminance over that of bare asphalt."""
    return frame.luminance / np.median(frame.luminance[-40:])


def test_a_zebra_on_a_curve_lies_where_its_corners_project():
    camera = camera_on(CURVED, OVERCAST)
    x, y, yaw = (float(v) for v in to_world(CURVED, 26.0, -1.75))
    scene = ego_at(x, y, yaw)
    frame, pose = camera.render(scene), camera_pose(camera.config, scene.ego)
    checked = 0
    for row in range(100, 256):
        for column in range(2, 448, 3):
            if frame.instance[row, column] != StaticClass.GROUND or row < 140:
                continue
            edges = [
                ground_under(pose, column + a, row + b)[:2] for a, b in ((-1, -1), (2, -1), (2, 2), (-1, 2))
            ]
            s, d = to_street(CURVED, *np.array(edges).T)
            if abs(d).max() > 3.3 or s.max() - s.min() > 1.0:
                continue
            on_zebra = s.min() > 38.0 and s.max() < 42.0
            stripe = np.floor(d[0] / 0.5) == np.floor(d / 0.5)
            if on_zebra and stripe.all():
                bright = _white(frame)[row, column] > 2.0
                assert bright == (np.floor(d[0] / 0.5) % 2 == 0)
                checked += 1
    assert checked > 60
    corners = np.stack(
        [*to_world(CURVED, [38.0, 38.0, 42.0, 42.0], [0.5, 1.0, 0.5, 1.0])[:2], np.zeros(4)], axis=1
    )
    assert np.isfinite(project(pose, corners)).all()


@pytest.mark.parametrize("street", [CURVED, CROSSED], ids=["curve", "intersection"])
def test_no_sky_shows_below_the_roofs(street):
    """Rays that rise by less than 2 degrees meet a house wherever one looks: the ends of streets are 260 m away."""
    camera = camera_on(street, width_px=120, height_px=64, horizontal_fov_deg=90.0)
    places = [to_world(street, s, -1.75) for s in (5.0, 30.0, 55.0, 90.0)]
    if street.intersection is not None:
        places = [*turning_path(street, "right")[::40], *turning_path(street, "left")[::40]]
    for x, y, heading in places:
        for turn in (0.0, 1.5, 3.0, 4.5):
            scene = ego_at(float(x), float(y), float(heading) + turn)
            pose = camera_pose(camera.config, scene.ego)
            frame = camera.render(scene)
            top = math.ceil(pose.cy - pose.focal_px * math.tan(math.radians(2.0)))
            sky = frame.instance[top:] == StaticClass.SKY
            assert not sky.any(), (x, y, heading + turn, np.argwhere(sky)[:3] + np.array([top, 0]))


@pytest.mark.parametrize("weather", [Weather(), DRY_NIGHT], ids=["day", "night"])
def test_turning_through_the_intersection_never_jumps(weather):
    """Steps of 4 mm, or a thirtieth of a degree, move edges by up to .09 of a pixel: pixels change by little more."""
    camera = camera_on(CROSSED, weather, width_px=120, height_px=68)
    path = turning_path(CROSSED, "right", step_m=0.004)
    for start in range(4000, len(path) - 4000, 661):
        before, after = (camera.render(ego_at(*path[start + k])) for k in (0, 1))
        step = np.abs(after.luminance - before.luminance)
        if weather is DRY_NIGHT:  # lamps shine thousands of times brighter than all else: the ground alone
            step = step[ndimage.binary_erosion(before.instance == StaticClass.GROUND, np.ones((3, 3)))]
        assert step.max() < 0.12 * np.percentile(before.luminance, 99.5)


def _houses_only(camera):
    """Leave out trees, lamps and furniture."""
    scenery = camera._scenery
    roofs = scenery.props.idents[:, 0] == StaticClass.BUILDING
    props = replace(
        scenery.props, **{k: getattr(scenery.props, k)[roofs] for k in ("numbers", "idents", "looks")}
    )
    camera._line(replace(scenery, groups=scenery.groups[:0], props=props), camera._weather, camera._light)
    return camera


def _largest_step(camera, before, after):
    before, after = camera.render(before), camera.render(after)
    step = np.abs(after.luminance - before.luminance)[before.instance == StaticClass.BUILDING]
    return step.max(initial=0.0) / np.percentile(before.luminance, 99.5)


@pytest.mark.parametrize("seed", [5, 6])
@pytest.mark.parametrize("way", ["right", "left"])
def test_houses_at_an_intersection_change_no_more_than_their_edges_move(seed, way):
    """A millimetre, or .008 degrees of the turn, moves edges by .02 of a pixel."""
    street = replace(CROSSED, seed=seed)
    camera = _houses_only(camera_on(street, width_px=120, height_px=68))
    path = turning_path(street, way, step_m=0.001)
    for start in range(16000, len(path) - 16000, 173):
        assert _largest_step(camera, ego_at(*path[start]), ego_at(*path[start + 1])) < 0.04, start


@pytest.mark.parametrize("seed", [STREET.seed, 6, 8])
def test_houses_along_a_straight_street_change_no_more_than_their_edges_move(seed):
    camera = Renderer(CameraConfig(width_px=120, height_px=68))
    camera.load(replace(STREET, seed=seed), Weather())
    _houses_only(camera)
    for x in np.arange(-20.0, 60.0, 0.437):
        assert _largest_step(camera, ego_at(x, -1.75, 0.0), ego_at(x + 0.001, -1.75, 0.0)) < 0.015, x


def test_stop_lines_and_zebras_are_on_all_four_arms():
    camera = camera_on(CROSSED, OVERCAST)
    crossing = CROSSED.intersection
    for quarter, reach in (
        (0, crossing.kerb_m),
        (1, CROSSED.kerb_y_m),
        (2, crossing.kerb_m),
        (3, CROSSED.kerb_y_m),
    ):
        away = reach + crossing.corner_radius_m
        heading = 0.5 * math.pi * quarter
        c, s = round(math.cos(heading)), round(math.sin(heading))

        def place(ahead, left, c=c, s=s):
            return 60.0 + c * ahead - s * left, s * ahead + c * left

        eye = place(-away - crossing.crosswalk_width_m - 8.0, -1.75)
        scene = ego_at(*eye, heading)
        frame, pose = camera.render(scene), camera_pose(camera.config, scene.ego)

        def brightness(ahead, left, frame=frame, pose=pose, place=place):
            u, v, _ = project(pose, np.array([[*place(ahead, left), 0.0]]))[0]
            return _white(frame)[int(v), int(u)]

        stop = -away - crossing.crosswalk_width_m - 1.4
        assert brightness(stop, -1.5) > 2.5
        assert brightness(stop, 1.5) < 1.5
        assert brightness(stop - 1.5, -1.5) < 1.5
        middle = -away - 0.5 * crossing.crosswalk_width_m
        stripes = [brightness(middle, d) > 1.7 for d in np.arange(-2.75, 3.0, 0.5)]
        assert sum(a != b for a, b in itertools.pairwise(stripes)) == len(stripes) - 1


def test_a_building_hides_who_stands_in_the_other_street():
    camera = camera_on(CROSSED, OVERCAST)
    behind = pedestrian(9, 60.0, 30.0)
    assert not (camera.render(ego_at(20.0, -1.75, 0.0, behind)).instance == 9).any()
    assert (camera.render(ego_at(60.0, 5.0, math.pi / 2, behind)).instance == 9).any()


def test_the_same_layout_gives_the_same_bytes():
    scene = ego_at(57.0, -2.0, 0.6)
    first, second = (camera_on(CROSSED, NIGHT, width_px=64, height_px=48).render(scene) for _ in range(2))
    assert first.radiance.tobytes() == second.radiance.tobytes()


@pytest.mark.parametrize("roll_deg", [5.0, -5.0])
@pytest.mark.parametrize("weather", [Weather(), Weather(wetness=1.0, cloudiness=1.0)], ids=["dry", "wet"])
def test_a_rolled_camera_sees_the_level_image_turned(roll_deg, weather):
    level, rolled = (
        camera_on(STREET, weather, width_px=200, height_px=200, roll_deg=r).render(
            snapshot(vehicle(4, 14, -4.6))
        )
        for r in (0.0, roll_deg)
    )
    # the camera's right side goes down for a positive roll: the image turns the other way about its middle
    turned = ndimage.rotate(level.luminance, -roll_deg, reshape=False, order=1)[40:160, 40:160]
    other = ndimage.rotate(level.luminance, roll_deg, reshape=False, order=1)[40:160, 40:160]
    seen, white = rolled.luminance[40:160, 40:160], np.percentile(level.luminance, 99)
    error = min(np.abs(seen - turned).mean(), np.abs(seen - other).mean())
    assert error < 0.03 * white
    assert error < 0.4 * np.abs(seen - level.luminance[40:160, 40:160]).mean()


def test_depth_is_right_under_roll_pitch_and_a_turned_mount():
    camera = camera_on(STREET, width_px=96, height_px=64, roll_deg=-7.0, yaw_deg=40.0, pitch_deg=5.0)
    frame, pose = camera.render(snapshot()), camera_pose(camera.config, snapshot().ego)
    rows, columns = np.nonzero(frame.instance == StaticClass.GROUND)
    for row, column in list(zip(rows, columns, strict=True))[::97]:
        expected = ground_under(pose, column + 0.5, row + 0.5)[2]
        assert frame.depth[row, column] == pytest.approx(expected, rel=1e-4)


def test_nothing_shines_through_where_two_pieces_of_a_front_meet():
    street = StreetSpec(seed=1, curvature_per_m=-1 / 40, curve_start_x_m=30.0, curve_length_m=45.0)
    x, y, heading = (float(v) for v in to_world(street, 45.0, -1.75))
    fine, coarse = (
        camera_on(street, width_px=160 * k, height_px=90 * k, horizontal_fov_deg=90.0).render(
            ego_at(x, y, heading)
        )
        for k in (4, 1)
    )
    mean = fine.luminance.reshape(90, 4, 160, 4).mean(axis=(1, 3))
    wall = ndimage.binary_erosion(coarse.instance == StaticClass.BUILDING, np.ones((5, 5)))
    assert np.median(np.abs(coarse.luminance / mean - 1)[wall]) < 0.01
    columns = np.median(np.where(wall, coarse.luminance / mean, np.nan)[8:40], axis=0)[5:60]
    assert np.nanmax(np.abs(columns - 1)) < 0.08

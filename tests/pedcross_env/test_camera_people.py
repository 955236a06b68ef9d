"""People: bodies that walk without slipping, jumping or popping, and what they wear."""

import math
from dataclasses import replace
from itertools import pairwise, product

import numpy as np
import pytest
from camera_scenes import NIGHT, pedestrian, renderer, snapshot

from pedcross_env.camera.kernels.people import MAX_BODY, P_FINE, retro_coefficient
from pedcross_env.camera.kernels.pose import (
    ANKLE_Z,
    BALL_X,
    CRANK,
    CRANK_LENGTH,
    FOOT,
    FRAMES,
    HAND,
    HEEL_X,
    PELVIS,
    RIGHT,
    SHANK,
    TOES,
    duty_factor,
    pose_body,
)
from pedcross_env.camera.people import person_of
from pedcross_env.camera.riders import RIDER_HEIGHT_M, rider_of
from pedcross_env.errors import ConfigError
from pedcross_env.scenario import ACCESSORIES, Leg, PedestrianSpec, StreetSpec
from pedcross_env.weather.weather import Weather
from pedcross_env.world.pedestrians import Pedestrians

MODELS = [(0, 1.78), (1, 1.2), (2, 1.65)]
people = pytest.mark.parametrize(("model", "height_m"), MODELS, ids=["adult", "child", "elderly"])


def posed(phase, stride_m, height_m, model=0, seed=3):
    frames = np.zeros((FRAMES, 4, 3))
    pose_body(phase, stride_m, 0.0, height_m, person_of(model, seed, height_m).build, frames)
    return frames


def sole(frames, side=0):
    """(2, 3) heel and ball of a foot on its sole, shares of the height."""
    origin, ahead, _, up = frames[FOOT + RIGHT * side]
    return np.stack([origin - ANKLE_Z * up - HEEL_X * ahead, origin - ANKLE_Z * up + BALL_X * ahead])


@people
@pytest.mark.parametrize("share", [0.5, 0.7, 0.8])
def test_a_standing_foot_stays_where_it_is(model, height_m, share):
    """Over stance the point that bears on the ground moves back under the body by what the body goes ahead."""
    stride, duty = share * height_m, duty_factor(share, height_m)
    phases = np.linspace(0.5 - 0.49 * duty, 0.5 + 0.49 * duty, 60)
    soles = np.array([sole(posed(p, stride, height_m, model)) for p in phases]) * height_m
    world_x = soles[:, :, 0] + (phases * stride)[:, None]
    lowest = soles[:, :, 2].argmin(axis=1)
    assert np.ptp(world_x[lowest == 0, 0]) < 0.03
    assert np.ptp(world_x[lowest == 1, 1]) < 0.03
    assert np.abs(soles[:, :, 2].min(axis=1)).max() < 1e-6


@people
@pytest.mark.parametrize("share", [0.0, 0.3, 0.6, 0.85, 1.0, 1.25, 1.5])
def test_feet_never_sink_and_legs_reach_them(model, height_m, share):
    build = person_of(model, 3, height_m).build
    for phase in np.linspace(0, 1, 80):
        frames = posed(phase, share * height_m, height_m, model)
        heights = np.concatenate([sole(frames, 0), sole(frames, 1)])[:, 2]
        assert heights.min() > -1e-6
        assert heights.min() < 0.002 or share > 0.9  # walking, somebody's foot is always down
        for side in (0, RIGHT):
            ankle = frames[FOOT + side - 1, 0] - build[5] * frames[FOOT + side - 1, 3]
            assert np.linalg.norm(ankle - frames[FOOT + side, 0]) * height_m < 0.02


def test_runners_fly_and_walkers_do_not():
    def airborne(share):
        return [
            min(sole(posed(p, share * 1.78, 1.78), s)[:, 2].min() for s in (0, 1))
            for p in np.linspace(0, 1, 60)
        ]

    assert max(airborne(0.8)) < 1e-6
    assert max(airborne(1.3)) > 0.004


@people
def test_half_a_cycle_later_the_body_is_its_mirror_image(model, height_m):
    build = person_of(model, 3, height_m, "none").build
    for share in (0.7, 1.2):
        now, later = np.zeros((FRAMES, 4, 3)), np.zeros((FRAMES, 4, 3))
        pose_body(0.17, share * height_m, 0.0, height_m, build, now)
        pose_body(0.67, share * height_m, 0.0, height_m, build, later)
        mirrored = now[:, 0] * [1, -1, 1]
        np.testing.assert_allclose(later[5:12, 0], mirrored[12:19], atol=1e-9)
        np.testing.assert_allclose(later[:3, 0], mirrored[:3], atol=1e-9)


def test_nothing_jumps_while_somebody_sets_off_runs_and_stops():
    legs = (
        Leg(to_x_m=30.0, to_y_m=-2.0, speed_mps=1.4, wait_s=0.3),
        Leg(to_x_m=30.0, to_y_m=3.0, speed_mps=3.0),
    )
    crowd = Pedestrians((PedestrianSpec(behaviour="c", x_m=30.0, y_m=-6.0, legs=legs, seed=4),), StreetSpec())
    places = []
    for time in np.arange(0.2, 6.5, 0.001):
        pose = crowd.poses(time)
        frames = posed(float(pose.gait_phase[0]), float(pose.gait_stride[0]), 1.75)
        places.append(frames[:, 0] * 1.75)
    assert (
        np.abs(np.diff(places, axis=0)).max() < 0.025
    )  # a runner who stops within .3 s drops his arms quickly
    assert float(crowd.poses(9.0).gait_stride[0]) == 0.0


@people
@pytest.mark.parametrize(("share", "low"), [(0.0, 0.985), (0.8, 0.93), (1.2, 0.88)])
def test_people_are_as_tall_as_the_pinhole_says(model, height_m, share, low):
    """Standing to within 2 %; a stride and a run lower the head by what legs that reach the ground must give."""
    camera = renderer()
    scene = snapshot(
        pedestrian(7, 12.3, -1.75, model=model, height=height_m, gait_stride=share * height_m, seed=6)
    )
    rows = np.flatnonzero((camera.render(scene).instance == 7).any(axis=1))
    expected = camera.config.focal_px * height_m / 12.0
    assert low * expected - 1.5 < len(rows) < 1.03 * expected + 1.5


@pytest.mark.parametrize("stride", [1.4, 2.2])
def test_a_millisecond_changes_little(stride):
    """No part pops: the share of the picture that changes follows the motion."""
    camera = renderer(width_px=200, height_px=160)
    shots = [
        camera.render(
            snapshot(pedestrian(7, 5.0, -1.75 + 0.0015 * k, gait_stride=stride, gait_phase=0.3 + 0.001 * k))
        )
        for k in range(6)
    ]
    steps = [np.abs(b.luminance - a.luminance).max() / a.luminance.max() for a, b in pairwise(shots)]
    assert max(steps) < 0.12
    covers = [np.count_nonzero(s.instance == 7) for s in shots]
    assert np.abs(np.diff(covers)).max() < 0.02 * covers[0]


def test_all_accessories_belong_to_the_pedestrian():
    for accessory in ACCESSORIES[2:]:
        person = person_of(0, 5, 1.75, accessory, True)
        bare = person_of(0, 5, 1.75, "none", True)
        assert (person.body[:, 8] > 0).sum() > (bare.body[:, 8] > 0).sum()
        assert len(person.body) == MAX_BODY
        assert person.wears[-1] == accessory
    camera = renderer(Weather(rain_mm_h=4.0))
    area = {
        name: np.count_nonzero(
            camera.render(snapshot(pedestrian(7, 8.0, -1.75, accessory=ACCESSORIES.index(name)))).instance
            == 7
        )
        for name in ("none", "umbrella", "stroller")
    }
    assert area["umbrella"] > 1.15 * area["none"]
    assert area["stroller"] > 1.15 * area["none"]


@pytest.mark.parametrize("model", range(3))
def test_there_is_room_for_whatever_anybody_wears_and_carries(model):
    fullest = 0
    for seed, accessory in product(range(250), ACCESSORIES[1:]):
        body = person_of(model, seed, 1.75, accessory, True).body
        fullest = max(fullest, np.count_nonzero(body[:, 8]))
    assert 64 < fullest < MAX_BODY


def test_there_is_room_for_every_cyclist_with_its_bicycle():
    assert 64 < max(np.count_nonzero(rider_of(seed).body[:, 8]) for seed in range(250)) < MAX_BODY


def test_the_rain_only_puts_up_umbrellas():
    for seed in range(40):
        dry, wet = person_of(0, seed, 1.75), person_of(0, seed, 1.75, "", True)
        assert dry.wears[:2] == wet.wears[:2]
        if "umbrella" not in wet.wears:
            np.testing.assert_array_equal(dry.body, wet.body)
    assert {person_of(0, seed, 1.75).wears[-1] for seed in range(80)} >= {
        "umbrella",
        "backpack",
        "handbag",
        "none",
    }


def test_people_differ_by_seed_and_never_have_too_many_parts():
    for model, height in MODELS:
        bodies = {person_of(model, seed, height, "umbrella", True).body.tobytes() for seed in range(60)}
        assert len(bodies) == 60


def test_retro_reflection_falls_as_the_standard_says():
    for minutes, value in ((12, 330.0), (20, 250.0), (60, 25.0), (90, 10.0)):
        assert retro_coefficient(330.0, math.radians(minutes / 60)) == pytest.approx(value, rel=0.01)


def test_a_hi_vis_vest_outshines_cloth_in_the_headlights():
    camera = renderer(NIGHT, width_px=1200, height_px=300, horizontal_fov_deg=20.0)

    def brightest(accessory):
        who = pedestrian(7, 50.0, -1.75, yaw=math.pi, seed=2, accessory=ACCESSORIES.index(accessory))
        frame = camera.render(snapshot(who, headlight=1.0))
        upper = (frame.instance == 7) & (np.arange(300)[:, None] < 150)
        return frame.luminance[upper].max()

    assert brightest("hi-vis") > 3.0 * brightest("none")


def test_shadows_follow_the_body():
    """The shadow on the road moves with who casts it."""
    camera = renderer(Weather(sun_altitude_deg=50.0, sun_azimuth_deg=90.0), width_px=300, height_px=200)
    empty = camera.render(snapshot()).luminance
    centres = []
    for y in (-2.5, -1.0):
        frame = camera.render(snapshot(pedestrian(7, 10.0, y, gait_stride=1.4, gait_phase=0.2)))
        shade = (frame.luminance < 0.9 * empty) & (frame.instance == -1)
        assert shade.sum() > 20
        centres.append(np.argwhere(shade)[:, 1].mean())
    expected = camera.config.focal_px * 1.5 / 10.0
    assert centres[0] - centres[1] == pytest.approx(expected, rel=0.25)


def test_an_unknown_accessory_is_refused_by_name():
    with pytest.raises(ConfigError, match="umbrella"):
        PedestrianSpec(behaviour="x", x_m=0.0, y_m=0.0, accessory="umbrela")


def test_who_looks_looks_both_ways():
    street, legs = StreetSpec(), (Leg(to_x_m=30.0, to_y_m=6.0, speed_mps=1.4, wait_s=9.0),)
    crowd = Pedestrians(
        tuple(
            PedestrianSpec(
                behaviour="c", x_m=30.0, y_m=-street.kerb_y_m - 0.3, yaw_rad=math.pi / 2, legs=legs, seed=s
            )
            for s in range(80)
        ),
        street,
    )
    heads = np.array([crowd.poses(t).head_yaw for t in np.arange(0.0, 9.0, 0.05)])
    looked = np.abs(heads).max(axis=0) > 0.5
    assert 0.75 < looked.mean() < 0.95
    assert (heads[:, looked].max(axis=0) > 0.5).all()
    assert (heads[:, looked].min(axis=0) < -0.5).all()


@pytest.mark.parametrize("seed", [0, 3, 11])
def test_a_cyclist_sits_on_the_saddle_with_its_feet_on_the_turning_pedals(seed):
    rider, frames = rider_of(seed), np.empty((FRAMES, 4, 3))
    for phase in np.arange(0.0, 1.0, 0.05):
        pose_body(phase, 1.0, 0.0, RIDER_HEIGHT_M, rider.build, frames)
        placed = frames * RIDER_HEIGHT_M
        assert placed[PELVIS, 0] == pytest.approx((-0.20, 0.0, 0.99))
        for k in range(2):
            turn = 2 * np.pi * (phase + 0.5 * k)
            pedal = np.array(CRANK) + CRANK_LENGTH * np.array([np.sin(turn), np.cos(turn)])
            ball = placed[TOES + RIGHT * k, 0]
            assert np.hypot(*(ball[[0, 2]] - pedal)) < 0.03
            knee, ankle = placed[SHANK + RIGHT * k, 0], placed[FOOT + RIGHT * k, 0]
            assert (
                np.linalg.norm(ankle - knee) < 1.06 * rider.build[5] * RIDER_HEIGHT_M
            )  # the leg reaches its foot
            hand = placed[HAND + RIGHT * k, 0]
            assert np.hypot(hand[0] - 0.34, hand[2] - 1.04) < 0.2


def alone(width_px, height_px):
    """Return a camera on a street where nothing stands but actors; ``_alpha`` is then what they cover."""
    made = renderer(width_px=width_px, height_px=height_px)
    scenery = made._scenery
    behind = scenery.panels[:1].copy()
    behind[:, 0] -= 1e4
    nothing = {name: getattr(scenery.props, name)[:0] for name in ("numbers", "idents", "looks")}
    props = replace(scenery.props, **nothing)
    made._line(
        replace(scenery, panels=behind, groups=scenery.groups[:0], props=props), made._weather, made._light
    )
    return made


def without_fingers(made):
    """Leave out what only shows from near by: pictures of other sizes then show the same."""
    appearance = made._actors._appearance

    def plainer(actors):
        *rest, bodies = appearance(actors)
        bodies[..., P_FINE][bodies[..., P_FINE] > 0] = np.inf
        return (*rest, bodies)

    made._actors._appearance = plainer
    return made


def walkers(distance_m):
    """One after the other, of every model, in every phase and from all sides."""
    for k, phase in enumerate(np.linspace(0.0, 0.95, 12)):
        walk = {"gait_phase": phase, "gait_stride": 1.2, "yaw": 0.8 * k}
        yield snapshot(pedestrian(5, distance_m, -1.6, model=k % 3, seed=k, **walk))


@pytest.mark.parametrize(("distance_m", "wider"), [(5.0, 0.01), (10.0, 0.04)])
def test_a_body_is_as_wide_as_in_a_finer_picture(distance_m, wider):
    """Parts that overlap at a body's edge, as at every joint, cover a pixel there once."""
    plain, fine = (without_fingers(alone(*size)) for size in ((240, 136), (960, 544)))
    for scene in walkers(distance_m):
        plain.render(scene)
        fine.render(scene)
        cover, exact = plain._canvas[0], fine._canvas[0].reshape(136, 4, 240, 4).mean(axis=(1, 3))
        assert 1.0 - wider < cover.sum() / exact.sum() < 1.0 + wider
        assert np.abs(cover - exact).sum() < 1.2 * wider * exact.sum()


def test_nothing_shows_through_where_limbs_meet():
    """A pixel that a four times finer picture covers wholly is covered, and shows nothing of who stands behind."""
    plain, fine = without_fingers(alone(240, 136)), without_fingers(alone(960, 544))
    inside = 0
    for k, phase in enumerate(np.linspace(0.0, 0.9, 7)):
        walk = {"gait_phase": phase, "gait_stride": 1.2, "yaw": 0.8 * k}
        front = pedestrian(5, 5.0, -1.6, model=k % 3, seed=k, **walk)
        fine.render(snapshot(front))
        whole = fine._canvas[0].reshape(136, 4, 240, 4).min(axis=(1, 3)) > 0.999
        plain.render(snapshot(front))
        assert plain._canvas[0][whole].min() > 0.97
        dressed = [
            plain.render(snapshot(front, pedestrian(6, 6.5, -1.6, height=1.95, seed=seed))).luminance
            for seed in (1, 2)
        ]
        step = np.abs(dressed[0] - dressed[1])
        assert step.max() > 0.05 * dressed[0].max()  # whoever stands behind is seen beside
        assert step[whole].max() < 0.02 * step.max()
        inside += whole.sum()
    assert inside > 2000

"""Truth beside the picture, against analytic geometry and against the picture itself."""

import dataclasses
import math

import cv2
import numpy as np
import pytest
from camera_scenes import pedestrian, renderer, snapshot, vehicle

from pedcross_env.camera import camera_pose, project
from pedcross_env.camera.truth import SeenClass, class_image, optical_flow, pedestrians_in, truth_of
from pedcross_env.config import EnvConfig
from pedcross_env.contracts import StaticClass
from pedcross_env.env import CrossingEnv
from pedcross_env.errors import ConfigError


def truth(camera, scene, other=None):
    return truth_of(camera.render(scene), scene, camera, other)


@pytest.fixture(scope="module")
def camera():
    return renderer()


@pytest.mark.parametrize(("height_m", "distance_m"), [(1.75, 8.0), (1.2, 15.0), (1.9, 30.0)])
def test_the_amodal_box_is_as_tall_as_the_pinhole_says(camera, height_m, distance_m):
    (person,) = truth(camera, snapshot(pedestrian(7, 0.3 + distance_m, -1.75, height=height_m))).pedestrians
    expected = camera.config.focal_px * height_m / distance_m
    assert person.amodal_box[3] - person.amodal_box[1] == pytest.approx(expected, abs=1.5 + 0.02 * expected)
    assert person.distance_m == pytest.approx(distance_m)


def test_alone_it_is_wholly_visible_and_its_boxes_agree(camera):
    for x in (6.0, 15.0, 39.0):
        (person,) = truth(
            camera, snapshot(pedestrian(7, x, -1.0, gait_stride=1.4, gait_phase=0.2))
        ).pedestrians
        assert person.visible_fraction == pytest.approx(1.0, abs=0.06)
        assert person.visible_box == pytest.approx(person.amodal_box, abs=1.01)


def test_boxes_bound_the_ids(camera):
    scene = snapshot(pedestrian(7, 14.0, -0.5), pedestrian(8, 20.0, -2.5), vehicle(9, 11.0, -2.4))
    found = truth(camera, scene)
    assert [p.actor_id for p in found.pedestrians] == [7, 8]
    for person in found.pedestrians:
        rows, columns = np.nonzero(found.instance == person.actor_id)
        if person.visible_box is not None:
            left, top, right, bottom = person.visible_box
            assert (columns.min(), rows.min(), columns.max() + 1, rows.max() + 1) == (
                left,
                top,
                right,
                bottom,
            )
            assert person.amodal_box[0] - 1 <= left
            assert bottom <= person.amodal_box[3] + 1


def test_behind_a_bus_nothing_is_visible_yet_the_box_is_known(camera):
    person = pedestrian(7, 24.0, -1.75)
    bus = vehicle(9, 15.0, -1.75, model=4, length=12.0, width=2.55, height=3.1)
    (hidden,) = truth(camera, snapshot(person, bus)).pedestrians
    (free,) = truth(camera, snapshot(person)).pedestrians
    assert hidden.visible_fraction == 0
    assert hidden.visible_box is None
    assert hidden.amodal_box == free.amodal_box


def test_a_car_hides_the_lower_part(camera):
    """Seen from 1.35 m, over a 1.45 m high roof edge, an adult right behind it shows the head and shoulders' share."""
    person, car = pedestrian(7, 14.6, -1.75), vehicle(9, 11.0, -1.75, height=1.45)
    (half,) = truth(camera, snapshot(person, car)).pedestrians
    assert 0.1 < half.visible_fraction < 0.6
    assert half.visible_box is not None
    assert half.visible_box[1] == pytest.approx(half.amodal_box[1], abs=1.01)
    assert half.visible_box[3] < half.amodal_box[3] - 10


def test_everybody_in_the_picture_is_found_wherever_the_optical_axis_is():
    crowd = [pedestrian(10 + k, 14.0 + k, -9.0 + 2.4 * k) for k in range(7)]
    for point in ((0.5, 0.5), (0.3, 0.7), (0.7, 0.3)):
        camera = renderer(principal_point=point, width_px=300, height_px=220)
        found = truth(camera, snapshot(*crowd))
        assert {p.actor_id for p in found.pedestrians if p.visible_box} == set(
            np.unique(found.instance)
        ) & set(range(10, 17))
        assert len(found.pedestrians) >= 4


def test_more_cover_less_visible(camera):
    """A car drawn across in front hides ever more."""
    shares = []
    for y in (2.5, 1.6, 1.2, 0.8, 0.2, -0.6):
        scene = snapshot(pedestrian(7, 18.0, -1.0, yaw=0.0), vehicle(9, 12.0, y, height=1.9, model=3))
        shares += [p.visible_fraction for p in truth(camera, scene).pedestrians]
    assert shares == sorted(shares, reverse=True)
    assert shares[0] > 0.95 > 0.4 > shares[-1]


def test_what_the_edge_cuts_is_truncated_not_hidden(camera):
    edge_y = -1.75 - 8.0 * 225 / camera.config.focal_px  # the middle of the body is on the right edge
    (person,) = truth(camera, snapshot(pedestrian(7, 8.3, edge_y, yaw=0.0))).pedestrians
    assert person.truncated_fraction == pytest.approx(0.5, abs=0.1)
    assert person.visible_fraction == pytest.approx(1.0, abs=0.06)
    assert person.amodal_box[2] > 450


def test_classes_follow_the_ids(camera):
    scene = snapshot(pedestrian(7, 14.0, -0.5), vehicle(8, 20.0, 1.75))
    found = truth(camera, scene)
    for static in StaticClass:
        assert (found.classes[found.instance == static] == SeenClass[static.name]).all()
    assert (found.classes[found.instance == 7] == SeenClass.PEDESTRIAN).all()
    assert (found.classes[found.instance == 8] == SeenClass.VEHICLE).all()
    assert {SeenClass.PEDESTRIAN, SeenClass.VEHICLE, SeenClass.GROUND, SeenClass.SKY} <= set(
        np.unique(found.classes)
    )
    assert class_image(np.zeros((0, 4), np.int32), scene).shape == (0, 4)


def test_flow_of_the_ground_is_the_difference_of_projected_points(camera):
    before, after = snapshot(x=0.0), snapshot(x=0.3, yaw=0.004, pitch=0.003)
    frame = camera.render(before)
    flow = optical_flow(frame, before, after, camera)
    points = np.array([[8.0, -1.0, 0.0], [12.0, 0.5, 0.0], [20.0, -3.0, 0.0]])
    first, second = (project(camera_pose(camera.config, s.ego), points)[:, :2] for s in (before, after))
    for (u, v), expected in zip(first, second - first, strict=True):
        assert frame.instance[int(v), int(u)] == StaticClass.GROUND
        assert flow[int(v), int(u)] == pytest.approx(expected, abs=0.05 + 0.1 * np.abs(expected).max())


def test_flow_of_the_sky_is_the_turn_alone(camera):
    before, after = snapshot(), snapshot(x=2.0, yaw=0.002)
    frame = camera.render(before)
    sky = optical_flow(frame, before, after, camera)[frame.instance == StaticClass.SKY]
    assert sky[:, 0].mean() == pytest.approx(camera.config.focal_px * 0.002, rel=0.1)


def test_flow_of_an_actor_is_its_own_motion(camera):
    before, after = snapshot(vehicle(8, 15.0, 0.0)), snapshot(vehicle(8, 15.0, 0.2))
    frame = camera.render(before)
    flow = optical_flow(frame, before, after, camera)
    own = frame.instance == 8
    expected = -0.2 * camera.config.focal_px / frame.depth[own]
    np.testing.assert_allclose(flow[own][:, 0], expected, atol=1e-3)
    np.testing.assert_allclose(flow[own][:, 1], 0.0, atol=1e-3)
    assert np.isnan(optical_flow(frame, before, snapshot(), camera)[own]).all()


def test_the_next_picture_is_this_one_moved_by_the_flow(camera):
    before = snapshot(vehicle(8, 15.0, 1.75), vehicle(9, 22.0, -4.6))
    after = snapshot(vehicle(8, 14.8, 1.75), vehicle(9, 22.0, -4.6), x=0.15)
    first, second = camera.render(before), camera.render(after)
    back = optical_flow(second, after, before, camera)
    rows, columns = np.mgrid[0:256, 0:450].astype(np.float32)
    warped = cv2.remap(first.luminance, columns + back[..., 0], rows + back[..., 1], cv2.INTER_LINEAR)
    # interpolation blurs texture finer than a pixel: compare what a softer eye sees
    soft, warped, old = (
        cv2.GaussianBlur(image, (0, 0), 1.5)[10:246, 10:440]
        for image in (second.luminance, warped, first.luminance)
    )
    moved, still = np.abs(np.log(warped / soft)), np.abs(np.log(old / soft))
    assert np.percentile(moved, 80) < 0.4 * np.percentile(still, 80)
    assert np.mean(moved > 0.05) < 0.4 * np.mean(still > 0.05)


def test_through_a_lens_the_flow_follows_its_projection():
    camera = renderer(width_px=200, height_px=120, lens="brown", distortion=(-0.25, 0.05))
    before, after = snapshot(), snapshot(x=0.3)
    flow = optical_flow(camera.render(before), before, after, camera)
    point = np.array([[9.0, -3.0, 0.0]])
    first, second = (project(camera_pose(camera.config, s.ego), point)[0, :2] for s in (before, after))
    expected = second - first
    assert flow[int(first[1]), int(first[0])] == pytest.approx(
        expected, abs=0.05 + 0.1 * np.abs(expected).max()
    )


def test_ids_are_consistent_with_the_order_of_depth(camera):
    scene = snapshot(pedestrian(7, 10.0, -1.0), vehicle(8, 16.0, -1.6), vehicle(9, 26.0, -0.9))
    frame = camera.render(scene)
    for ident in (7, 8, 9):
        nearer = np.isin(frame.instance, [i for i in (7, 8, 9) if i < ident])
        alone = camera.render(dataclasses.replace(scene, actors=scene.actors[scene.actors["id"] == ident]))
        covered = nearer & (alone.instance == ident)
        assert (frame.depth[covered] < alone.depth[covered] + 0.05).all()
    assert (frame.instance == 7).any()


def test_the_env_tells_the_truth_of_its_picture():
    env = CrossingEnv(EnvConfig(modalities=("rgb",)))
    env.reset(seed=3)
    with pytest.raises(ConfigError, match="step"):
        env.truth(flow=True)
    for _ in range(20):
        env.step(np.zeros(1, np.float32))
    found = env.truth(flow=True)
    assert found.instance is env.sight.frame.instance
    assert found.flow_px.shape == (256, 450, 2)
    assert found.classes.dtype == np.uint8
    blind = CrossingEnv(EnvConfig(modalities=()))
    blind.reset(seed=3)
    for _ in range(20):
        blind.step(np.zeros(1, np.float32))
    assert np.array_equal(blind.truth().instance, found.instance)


def test_a_frame_without_ids_is_refused(camera):
    scene = snapshot()
    with pytest.raises(ConfigError, match="instance"):
        pedestrians_in(camera.render(scene, luminance_only=True), scene, camera)
    assert math.isnan(camera.visible_fraction(camera.render(scene, luminance_only=True), scene, 7))

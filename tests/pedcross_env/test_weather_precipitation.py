"""Rain: how much of it there is, where its drops are, what they cover."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from pedcross_env.camera import CameraPose
from pedcross_env.contracts import Frame
from pedcross_env.env import CrossingEnv
from pedcross_env.optics import distort
from pedcross_env.weather import Precipitation, Weather
from pedcross_env.weather._rain_kernels import _streak
from pedcross_env.weather.precipitation import (
    drop_density_per_m3_mm,
    fall_speed_mps,
    flake_density_per_m3_mm,
    flake_speed_mps,
)  # fmt: skip

WIDTH, HEIGHT = 450, 256
FOCAL = 0.5 * WIDTH / math.tan(math.radians(30))
FORWARD = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
AIRLIGHT = 1000.0
STEP_S = 4e-3
DROP = 0.95 * 0.5 * AIRLIGHT  # on a black picture


def view(x: float = 0.0, y: float = 0.0, yaw: float = 0.0) -> CameraPose:
    c, s = math.cos(yaw), math.sin(yaw)
    turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return CameraPose(np.array([x, y, 1.35]), FORWARD @ turn, FOCAL, 0.5 * WIDTH, 0.5 * HEIGHT, WIDTH, HEIGHT)


def black(radiance: bool = False) -> Frame:
    luminance = np.zeros((HEIGHT, WIDTH), np.float32)
    return Frame(luminance, np.stack([luminance] * 3) if radiance else None, None, None, AIRLIGHT)


def rain(rate: float, seed: int = 1, wind: float = 0.0) -> Precipitation:
    return Precipitation(Weather(rain_mm_h=rate, wind_mps=wind), seed)


def picture(drops: Precipitation, pose: CameraPose, time_s: float, exposure_s: float = 0.0) -> np.ndarray:
    frame = black()
    drops.draw(frame, pose, time_s, exposure_s, 0.0)
    return frame.luminance.astype(np.float64) / DROP


def drawn_depth_m(diameters_mm: np.ndarray, least_px: float) -> np.ndarray:
    """How deep drops are drawn: from 0.4 m to where they are least_px wide, fading over the last 1.4 of its inverse."""
    inverse = np.linspace(1e-3, 2.5, 20_001)  # of the depth, 1/m
    farthest = 1e-3 * diameters_mm * FOCAL / least_px
    strength = np.clip((farthest[:, None] * inverse - 1) / 0.4, 0, 1)
    return np.trapezoid(strength / inverse**2, inverse, axis=1)


def expected_cover(rate: float) -> float:
    """Mean covered share of the view: integral of N(D) D^2 over sizes and the depths they are drawn in."""
    diameters = np.linspace(0.4, 6.0, 201)
    density = np.array([drop_density_per_m3_mm(d, rate) for d in diameters])
    return float(np.trapezoid(density * (1e-3 * diameters) ** 2 * drawn_depth_m(diameters, 0.35), diameters))


@pytest.mark.parametrize(("rate", "yaw"), [(10.0, 0.0), (50.0, 0.7)])
@pytest.mark.parametrize("exposure_s", [0.0, 0.004])
def test_drawn_rain_covers_what_marshall_and_palmer_say(rate: float, yaw: float, exposure_s: float) -> None:
    drops = rain(rate, wind=3.0)
    means = [picture(drops, view(yaw=yaw), float(t), exposure_s).mean() for t in range(40)]
    error = float(np.std(means)) / math.sqrt(len(means))
    assert error < 0.05 * expected_cover(rate)
    assert abs(np.mean(means) - expected_cover(rate)) < 4 * error


def test_a_drop_falls_straight_at_its_own_speed() -> None:
    """Followed over three sub-frames: even steps downwards, same size, and a speed that fits that size."""
    drops, followed = rain(0.02), 0
    y, x = np.mgrid[:HEIGHT, :WIDTH] + 0.5
    for second in range(500):
        images = [picture(drops, view(), second + k * STEP_S) for k in range(3)]
        counts = [drops.draw(black(), view(), second + k * STEP_S, 0.0, 0.0) for k in range(3)]
        if counts != [1, 1, 1] or any(_touches_edge(image) for image in images):
            continue
        mass = [image.sum() for image in images]
        if math.sqrt(min(mass)) < 0.5:  # still fading in: its cover tells nothing of its width
            continue
        cx = [float((x * image).sum() / image.sum()) for image in images]
        cy = [float((y * image).sum() / image.sum()) for image in images]
        first, second_step = cy[1] - cy[0], cy[2] - cy[1]
        assert mass[1] == pytest.approx(mass[0], rel=0.01)
        # A drop narrower than a pixel is found only to within that pixel.
        assert cx[1] == pytest.approx(cx[0], abs=0.01)
        assert first == pytest.approx(second_step, abs=1.3)
        width_px = math.sqrt(float(np.mean(mass)))
        # step / width = v(D) dt / D, and every drop is 0.4 to 6 mm across.
        ratios = [fall_speed_mps(d) * STEP_S / (1e-3 * d) for d in (6.0, 0.4)]
        assert 0.8 * min(ratios) < 0.5 * (first + second_step) / width_px < 1.3 * max(ratios)
        followed += 1
    assert followed >= 3


def _touches_edge(image: np.ndarray) -> bool:
    return bool(image[:2].any() or image[-2:].any() or image[:, :2].any() or image[:, -2:].any())


def test_a_camera_aside_sees_the_same_drops_with_parallax() -> None:
    """From 2 cm to the left every drop is 0.02 f / z further right, in the same row, of the same size."""
    drops, same, pairs = rain(0.02), 0, 0
    for second in range(300):
        pair = [picture(drops, view(y=y), float(second)) for y in (0.0, 0.02)]
        counts = [drops.draw(black(), view(y=y), float(second), 0.0, 0.0) for y in (0.0, 0.02)]
        if counts != [1, 1] or any(_touches_edge(image) for image in pair):
            continue
        pairs += 1
        rows, columns, masses = (np.array(values) for values in zip(*map(_centroid, pair), strict=True))
        shift = columns[1] - columns[0]
        depth_m = 0.02 * FOCAL / max(shift, 1e-9)
        same += bool(
            abs(rows[1] - rows[0]) < 0.01 and abs(masses[1] / masses[0] - 1) < 0.01 and depth_m > 0.38
        )
    # One drop may leave the view just as another comes in: that is a pair of strangers.
    assert pairs >= 5
    assert same >= 0.8 * pairs


def _centroid(image: np.ndarray) -> tuple[float, float, float]:
    rows, columns = np.mgrid[:HEIGHT, :WIDTH] + 0.5
    total = float(image.sum())
    return float((rows * image).sum()) / total, float((columns * image).sum()) / total, total


def test_a_camera_with_a_wider_view_sees_the_same_drops_in_the_shared_part() -> None:
    drops, wide = rain(30.0), np.zeros((HEIGHT, 600), np.float32)
    pose = replace(view(), cx=300.0, width_px=600)
    drops.draw(Frame(wide, None, None, None, AIRLIGHT), pose, 3.0, 0.003, 5.0)
    narrow = black()
    drops.draw(narrow, view(), 3.0, 0.003, 5.0)
    assert narrow.luminance.any()
    np.testing.assert_allclose(wide[:, 75:525], narrow.luminance, atol=1e-3 * DROP)


def test_a_telephoto_lens_sees_the_same_drops_farther_away() -> None:
    """Twice the focal length: what the wide lens sees in its middle, larger, and further small drops."""
    drops = rain(100.0)
    wide, tele = black(), black()
    drops.draw(wide, view(), 3.0, 0.0, 0.0)
    drops.draw(tele, replace(view(), focal_px=2 * FOCAL), 3.0, 0.0, 0.0)
    halves = tele.luminance.reshape(HEIGHT // 2, 2, WIDTH // 2, 2).mean(axis=(1, 3))
    left, top = WIDTH // 4, HEIGHT // 4
    middle = wide.luminance[top : top + HEIGHT // 2, left : left + WIDTH // 2]
    clear = middle > 0.5 * DROP
    assert clear.sum() > 20
    assert (halves[clear] > 0.2 * DROP).mean() > 0.9


@pytest.mark.parametrize(
    ("lens", "k"), [("brown", (-0.25, 0.04, 0.002, -0.001)), ("fisheye", (-0.03, -0.007, 0.01, 0.0))]
)
def test_drops_are_where_the_lens_shows_them(lens: str, k: tuple[float, ...]) -> None:
    """A drop's centroid in the pinhole's picture, bent by the formulas of optics, is its centroid in the lens's."""
    drops, found = rain(0.02), 0
    for second in range(400):
        poses = view(), replace(view(), lens=lens, distortion=k)
        images = [picture(drops, pose, float(second)) for pose in poses]
        if any(image.max() < 0.2 or _touches_edge(image) for image in images):
            continue
        if any(drops.draw(black(), pose, float(second), 0.0, 0.0) != 1 for pose in poses):
            continue
        (row, column, _), seen = (_centroid(image) for image in images)
        bent = distort(lens, k, np.array((column - WIDTH / 2) / FOCAL), np.array((row - HEIGHT / 2) / FOCAL))
        expected = [HEIGHT / 2 + FOCAL * float(bent[1]), WIDTH / 2 + FOCAL * float(bent[0])]
        assert np.hypot(seen[0] - expected[0], seen[1] - expected[1]) < 0.5
        found += 1
    assert found >= 5


def test_a_long_exposure_is_the_mean_of_the_short_ones_it_consists_of() -> None:
    drops, exposure_s, parts = rain(30.0, wind=4.0), 0.008, 8
    whole = picture(drops, view(), 5.0, exposure_s)
    short = exposure_s / parts
    starts = 5.0 - exposure_s / 2 + short * np.arange(parts)
    mean = np.mean([picture(drops, view(), start + short / 2, short) for start in starts], axis=0)
    assert mean.sum() == pytest.approx(whole.sum(), rel=0.05)
    assert np.abs(whole - mean).sum() < 0.25 * whole.sum()


def test_driving_into_the_rain_slants_the_streaks_outwards() -> None:
    still, driving = black(), black()
    drops = rain(30.0)
    drops.draw(still, view(), 1.0, 0.008, 0.0)
    drops.draw(driving, view(), 1.0, 0.008, 15.0)
    assert not np.array_equal(still.luminance, driving.luminance)
    # Without wind and speed a streak stays in its columns: sideways gradients exceed those along it.
    for frame, sign in ((still, 1), (driving, -1)):
        edge = frame.luminance[:, : WIDTH // 5]
        slant = np.abs(np.diff(edge, axis=1)).sum() / np.abs(np.diff(edge, axis=0)).sum()
        assert sign * (slant - 3.0) > 0


def test_more_rain_draws_more_drops() -> None:
    counts = [rain(rate).draw(black(), view(), 1.0, 0.003, 10.0) for rate in (0.0, 1.0, 5.0, 20.0, 80.0)]
    assert counts[0] == 0
    assert counts == sorted(set(counts))


def test_rain_behind_a_surface_is_hidden() -> None:
    drops = rain(60.0)
    free, wall, argument = black(), black(), black()
    wall.depth = np.full((HEIGHT, WIDTH), 0.8, np.float32)
    drops.draw(free, view(), 1.0, 0.002, 0.0)
    drops.draw(wall, view(), 1.0, 0.002, 0.0)
    drops.draw(argument, view(), 1.0, 0.002, 0.0, depth=wall.depth)
    np.testing.assert_array_equal(wall.luminance, argument.luminance)
    assert 0 < wall.luminance.sum() < 0.5 * free.luminance.sum()
    blocked = black()
    assert drops.draw(blocked, view(), 1.0, 0.002, 0.0, depth=np.full((HEIGHT, WIDTH), 0.3, np.float32)) == 0
    assert not blocked.luminance.any()


def test_luminance_and_radiance_get_the_same_rain() -> None:
    full, only = black(radiance=True), black()
    drops = rain(40.0)
    drops.draw(full, view(), 1.0, 0.004, 8.0)
    drops.draw(only, view(), 1.0, 0.004, 8.0)
    np.testing.assert_array_equal(full.luminance, only.luminance)
    assert full.radiance is not None
    for plane in full.radiance:
        np.testing.assert_array_equal(plane, full.luminance)


def test_streaks_only_move_a_pixel_towards_the_drops_brightness() -> None:
    image = picture(rain(200.0), view(), 1.0, 0.002)
    assert image.min() >= 0
    assert image.max() <= 1 + 1e-6


def test_same_seed_same_drops() -> None:
    first = picture(rain(20.0, seed=4), view(), 2.0, 0.003)
    np.testing.assert_array_equal(first, picture(rain(20.0, seed=4), view(), 2.0, 0.003))
    assert not np.array_equal(first, picture(rain(20.0, seed=5), view(), 2.0, 0.003))


def snow(rate: float, seed: int = 1, wind: float = 0.0) -> Precipitation:
    return Precipitation(Weather(snow_mm_h=rate, wind_mps=wind), seed)


def test_flakes_carry_the_snow_rate_they_are_drawn_from() -> None:
    """Mass flux of Gunn and Marshall's flakes at 1 m/s and more: the rate, within what their fit leaves open."""
    diameters = np.linspace(0.05, 40.0, 8001)
    for rate in (0.5, 2.0):
        density = np.array([flake_density_per_m3_mm(d, rate) for d in diameters])
        speed = np.array([flake_speed_mps(d) for d in diameters])
        melted_mm = (diameters / 2.295) ** (1 / 1.4437)
        flux_mm_h = (
            np.trapezoid(density * math.pi / 6 * (1e-3 * melted_mm) ** 3 * speed, diameters) * 1000 * 3600
        )
        assert 0.5 * rate < flux_mm_h < 2.0 * rate


def test_drawn_snow_covers_what_its_sizes_say() -> None:
    diameters = np.linspace(1.0, 16.0, 201)
    density = np.array([flake_density_per_m3_mm(d, 2.0) for d in diameters])
    depths = drawn_depth_m(diameters, 0.5)
    expected = float(np.trapezoid(density * (1e-3 * diameters) ** 2 * depths, diameters))
    share = 0.95 / 0.9  # picture() counts in the brightness of raindrops
    means = [share * picture(snow(2.0, wind=2.0), view(), float(t)).mean() for t in range(40)]
    error = float(np.std(means)) / math.sqrt(len(means))
    assert error < 0.05 * expected
    assert abs(np.mean(means) - expected) < 4 * error + 0.02 * expected


@pytest.mark.parametrize(("length_px", "blur_px"), [(0.0, 0.0), (0.0, 6.0), (3.0, 2.0), (30.0, 2.0)])
def test_near_flakes_are_soft_all_round_and_cover_what_they_did(length_px: float, blur_px: float) -> None:
    image, width_px = np.zeros((64, 96), np.float32), 7.0
    none, nowhere = np.empty((0, 0, 0), np.float32), np.empty((0, 0), np.float32)
    slope = 0.6, 0.8
    ends = [
        (48.3 + sign * 0.5 * length_px * slope[0], 31.6 + sign * 0.5 * length_px * slope[1])
        for sign in (-1, 1)
    ]
    _streak(image, none, nowhere, *ends[0], *ends[1], width_px, blur_px, 1.0, 1.0, 1.0, 1.0, False)
    assert image.sum() == pytest.approx(width_px**2, rel=0.02)
    assert 0 < image.max() <= 1
    steps = max(np.abs(np.diff(image, axis=0)).max(), np.abs(np.diff(image, axis=1)).max())
    assert steps < 0.4 * image.max()


def test_a_flake_that_glints_in_the_beam_fades_along_its_way_and_has_no_hard_edge() -> None:
    none, nowhere, width_px = np.empty((0, 0, 0), np.float32), np.empty((0, 0), np.float32), 1.0
    image, even = np.zeros((16, 64), np.float32), np.zeros((16, 64), np.float32)
    _streak(image, none, nowhere, 22.0, 8.5, 42.0, 8.5, width_px, 0.0, 1.0, 0.2, 1.8, 1.0, True)
    _streak(even, none, nowhere, 22.0, 8.5, 42.0, 8.5, width_px, 0.0, 1.0, 1.0, 1.0, 1.0, False)
    assert image.sum() == pytest.approx(even.sum(), rel=0.05)  # their mean brightness is the same
    assert image[:, 40].sum() > 4 * image[:, 24].sum()
    assert image[7].max() > 0.2 * image[8].max()  # beside its middle row, where the even one has nothing
    assert even[7].max() == 0.0


def test_flakes_sink_at_a_metre_per_second_and_sway() -> None:
    """A second picture fits the first best where flakes at 1 m/s would have sunk to, not where rain would have."""
    drops, depth_m = snow(3.0), 2.0
    before, after = picture(drops, view(), 1.0), picture(drops, view(), 1.01)
    shifts = range(-2, 20)
    scores = [
        float((before[: HEIGHT - 20] * after[k : HEIGHT - 20 + k]).sum()) if k >= 0 else 0.0 for k in shifts
    ]
    best = shifts[int(np.argmax(scores))]
    assert 0.4 < best / (0.01 * FOCAL / depth_m) < 3.0
    straight = picture(drops, view(), 1.0)
    np.testing.assert_array_equal(straight, before)


def test_more_snow_draws_more_flakes_and_both_kinds_fall_together() -> None:
    counts = [snow(rate).draw(black(), view(), 1.0, 0.003, 10.0) for rate in (0.0, 0.5, 2.0)]
    assert counts[0] == 0
    assert counts == sorted(set(counts))
    sleet = Precipitation(Weather(snow_mm_h=2.0, rain_mm_h=5.0), 1).draw(black(), view(), 1.0, 0.003, 10.0)
    assert sleet > counts[2]


def test_rain_asks_for_sub_frames_up_to_the_cap_and_says_what_it_got() -> None:
    """A standing car: nothing flows, but rain must not become one long faint streak."""
    camera = {"width_px": 48, "height_px": 32}
    found = {}
    for weather, cap in (("clear", 10), ("storm", 10), ("storm", 3), ("storm", None), ("snow", 10)):
        dvs = {"max_subframes": cap, "max_flow_px": 1e6}
        env = CrossingEnv({"weather": [weather], "modalities": ["dvs"], "camera": camera, "dvs": dvs})
        env.reset(seed=2)
        found[weather, cap] = env.step(np.zeros(1, np.float32))[-1]
    per_step = fall_speed_mps(2.0) / 2e-3 / 30
    assert (found["clear", 10]["subframes"], found["clear", 10]["streak"]) == (1, 0.0)
    assert found["storm", None]["subframes"] == found["storm", 10]["subframes"] == math.ceil(per_step / 16.0)
    assert found["storm", 10]["streak"] == pytest.approx(per_step / found["storm", 10]["subframes"])
    assert found["storm", 10]["streak"] <= 16.0
    assert found["storm", 3]["subframes"] == 3
    assert found["storm", 3]["streak"] == pytest.approx(per_step / 3)
    assert found["snow", 10]["subframes"] == 1

"""The RGB camera: exposure, noise, quantisation."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pedcross_env.config import RgbConfig
from pedcross_env.contracts import Frame
from pedcross_env.errors import ConfigError
from pedcross_env.sensors.rgb import expose, exposure_time_s, initial_rgb_state, metered_white

CLEAN = RgbConfig(noise=False)


def frame_of(luminance: np.ndarray) -> Frame:
    luminance = luminance.astype(np.float32)
    return Frame(luminance, np.stack([luminance] * 3), None, None, 0.0)


def flat(cd_m2: float, shape: tuple[int, int] = (100, 120)) -> Frame:
    return frame_of(np.full(shape, cd_m2))


def street(lux: float) -> np.ndarray:
    """Asphalt of albedo 0.2 and a white patch of albedo 0.9 over 4 % of the picture."""
    luminance = np.full((100, 120), 0.2 * lux / math.pi)
    luminance[40:60, 40:64] = 0.9 * lux / math.pi
    return luminance


def first_image(frame: Frame, config: RgbConfig, seed: int = 0) -> np.ndarray:
    return expose(initial_rgb_state(config), frame, 0.0, config, seed)[1]


def decode(image: np.ndarray) -> np.ndarray:
    """SRGB codes to linear shares of white."""
    code = image.astype(np.float64) / 255
    return np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)


@pytest.mark.parametrize("lux", [100.0, 2_000.0, 100_000.0])
def test_automatic_exposure_keeps_white_unclipped_and_asphalt_visible(lux: float) -> None:
    image = first_image(frame_of(street(lux)), CLEAN)
    assert 180 < image[50, 50, 0] < 255
    assert 60 < image[10, 10, 0] < 160


def test_a_bright_sky_does_not_crush_the_street() -> None:
    luminance = street(2_000.0)
    luminance[:35] = 2_500.0  # a white sky over the upper third, 20 times the asphalt
    image = first_image(frame_of(luminance), CLEAN)
    assert image[90, 10, 0] > 40


def test_picture_is_linear_light_in_srgb() -> None:
    config = RgbConfig(exposure="fixed", fixed_white_cd_m2=1000.0, noise=False)
    levels = np.linspace(0, 1.2, 60)
    image = first_image(frame_of(1000.0 * levels[None, :]), config)[0, :, 0]
    np.testing.assert_allclose(decode(image), np.minimum(levels, 1.0), atol=0.006)


@pytest.mark.parametrize("gain", [1.0, 16.0])
@pytest.mark.parametrize("level", [0.2, 0.6])
def test_noise_variance_is_electrons_plus_read_noise(gain: float, level: float) -> None:
    config = RgbConfig(exposure="fixed", fixed_white_cd_m2=400.0 / gain, read_noise_e=5.0)
    image = first_image(flat(level * 400.0 / gain, (200, 300)), config)
    well_e = 9000.0 / gain
    expected = (level * well_e + 5.0**2) / well_e**2
    slope = 255 * 1.055 / 2.4 * level ** (1 / 2.4 - 1)  # of the sRGB curve, codes per share of white
    rounding = 1 / 12 / slope**2 + 1 / 12 / 4095**2
    assert decode(image).var() == pytest.approx(expected + rounding, rel=0.06)
    assert decode(image).mean() == pytest.approx(level, rel=0.01)


def test_noise_of_neighbours_channels_and_frames_is_independent() -> None:
    config = RgbConfig(exposure="fixed", fixed_white_cd_m2=25.0)
    scene = flat(10.0, (150, 150))
    state, first = expose(initial_rgb_state(config), scene, 0.0, config, 1)
    _, second = expose(state, scene, 0.03, config, 1)
    a = first.astype(float) - first.mean()
    b = second.astype(float) - second.mean()
    pairs = {
        "columns": (a[:, 1:], a[:, :-1]),
        "rows": (a[1:], a[:-1]),
        "channels": (a[..., 0], a[..., 1]),
        "frames": (a, b),
    }
    for name, (one, other) in pairs.items():
        assert abs(np.corrcoef(one.ravel(), other.ravel())[0, 1]) < 0.03, name


def test_darkness_is_noisier_and_beyond_the_gain_dark() -> None:
    noise, mean = [], []
    for lux in (10_000.0, 30.0, 0.5):
        patch = first_image(frame_of(street(lux)), RgbConfig())[:35].astype(float)
        noise.append(decode(patch).std() / decode(patch).mean())
        mean.append(patch.mean())
    assert noise[0] < 0.3 * noise[1] < 0.3 * noise[2]
    assert mean[2] < 0.4 * mean[0]


def test_exposure_follows_a_change_with_its_time_constant() -> None:
    config = RgbConfig(noise=False, adaptation_s=0.25)
    state, before = expose(initial_rgb_state(config), flat(1000.0), 0.0, config, 0)
    target = metered_white(flat(10_000.0).luminance, config)
    start = state.white_cd_m2
    assert start is not None
    state, blinded = expose(state, flat(10_000.0), 1 / 30, config, 0)
    assert blinded.min() == 255 > before.max()
    for _ in range(29):
        state, image = expose(state, flat(10_000.0), 1 / 30, config, 0)
    assert state.white_cd_m2 is not None
    left = math.log(target / state.white_cd_m2) / math.log(target / start)
    assert left == pytest.approx(math.exp(-1.0 / 0.25), rel=1e-6)
    assert abs(int(image[0, 0, 0]) - int(before[0, 0, 0])) < 12


def test_shutter_shortens_in_bright_light_only() -> None:
    config = RgbConfig()
    times = []
    for lux in (1.0, 10.0, 20_000.0):
        state, _ = expose(initial_rgb_state(config), frame_of(street(lux)), 0.0, config, 0)
        times.append(exposure_time_s(state, config))
    assert times[0] == times[1] == config.longest_exposure_s
    assert times[2] < 0.2 * config.longest_exposure_s


def test_same_seed_same_bytes_and_inputs_stay() -> None:
    frame, config = frame_of(street(50.0)), RgbConfig()
    assert frame.radiance is not None
    radiance, luminance = frame.radiance.copy(), frame.luminance.copy()
    np.random.seed(5)  # noqa: NPY002
    before = np.random.get_state()[1].copy()  # type: ignore[index, union-attr]  # noqa: NPY002
    first, again = first_image(frame, config, 9), first_image(frame, config, 9)
    assert first.tobytes() == again.tobytes()
    assert first.tobytes() != first_image(frame, config, 10).tobytes()
    np.testing.assert_array_equal(frame.radiance, radiance)
    np.testing.assert_array_equal(frame.luminance, luminance)
    np.testing.assert_array_equal(np.random.get_state()[1], before)  # type: ignore[index]  # noqa: NPY002


def test_black_is_legal_and_luminance_alone_is_not() -> None:
    assert first_image(flat(0.0), CLEAN).max() == 0
    with pytest.raises(ConfigError, match="luminance only"):
        first_image(Frame(np.ones((4, 4), np.float32), None, None, None, 0.0), CLEAN)


def test_a_fixed_exposure_darker_than_the_gain_allows_is_refused() -> None:
    with pytest.raises(ConfigError, match="fixed_white_cd_m2"):
        RgbConfig(exposure="fixed", fixed_white_cd_m2=1.0)


def lamp_before_black(level: float, x: int = 60) -> Frame:
    luminance = np.zeros((100, 120))
    luminance[48:52, x : x + 4] = level
    return frame_of(luminance)


def test_saturated_pixels_spill_light_and_others_do_not() -> None:
    config = RgbConfig(exposure="fixed", fixed_white_cd_m2=100.0, noise=False)
    for level in (50.0, 199.0):
        image = first_image(lamp_before_black(level), config)
        assert not image[:40].any()
        assert not image[:, :50].any()
    bright, brighter = (first_image(lamp_before_black(level), config) for level in (1000.0, 2500.0))
    assert 0 < bright[44, 62, 0] < brighter[44, 62, 0]
    assert not bright[:, :45].any()
    off = RgbConfig(exposure="fixed", fixed_white_cd_m2=100.0, noise=False, bloom=0.0)
    assert not first_image(lamp_before_black(1000.0), off)[:47].any()


def test_bloom_keeps_the_light_it_spreads_up_to_its_cap() -> None:
    config = RgbConfig(exposure="fixed", fixed_white_cd_m2=100.0, noise=False, bloom=0.1)
    shares = [
        decode(first_image(lamp_before_black(level), config))[..., 0].sum() - 16
        for level in (400.0, 5000.0, 1e6)
    ]
    # Of the 16 pixels' excess of two whites a tenth is spread; what falls on the saturated ones themselves is not seen.
    assert 0.5 * 16 * 2 * 0.1 < shares[0] < 16 * 2 * 0.1
    assert shares[1] == pytest.approx(shares[2], rel=1e-6)
    assert shares[1] == pytest.approx(15 * shares[0], rel=0.15)


def test_without_saturation_bloom_changes_no_byte() -> None:
    scene, off = frame_of(street(50.0)), RgbConfig(exposure="fixed", fixed_white_cd_m2=100.0, bloom=0.0)
    on = RgbConfig(exposure="fixed", fixed_white_cd_m2=100.0)
    assert first_image(scene, on).tobytes() == first_image(scene, off).tobytes()

"""Settings of the event camera, and cameras by name."""

from __future__ import annotations

import types
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, get_args

from pedcross_env.errors import require, unknown_name
from pedcross_env.presets import changed_preset

__all__ = ["DVS_MODELS", "DVS_PRESETS", "DvsConfig", "DvsModel", "dvs_preset"]

DvsModel = Literal["pedcross", "carla", "v2e"]
DVS_MODELS: tuple[DvsModel, ...] = get_args(DvsModel)

_DARK_NOISE_HZ = 0.1
_LACKS: dict[DvsModel, tuple[str, ...]] = {
    "pedcross": (),
    "carla": ("cutoff_hz", "leak_hz", "shot_hz", "hot_share", "bus_events_per_s"),
    "v2e": ("hot_share", "bus_events_per_s"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class DvsConfig:
    """The event camera: which rule it follows, its pixels, its noise, and how densely the scene is sampled for it.

    Models, all on the logarithm of light:

    - ``pedcross``: an event at the very time at which the photoreceptor crosses the pixel's threshold, whatever the
      frame rate. The photoreceptor's pole is at ``cutoff_hz`` l / (l + ``cutoff_half_cd_m2``) for light l.
      After an event the pixel is held for the refractory period and starts anew from what it then sees.
    - ``carla``: CARLA's ``sensor.camera.dvs``, bit for bit, with its thresholds drawn anew in every frame.
    - ``v2e``: v2e's rule (Hu, Liu and Delbruck, CVPRW 2021): whole thresholds per frame, spread evenly over its time.

    The defaults are the thresholds of CARLA's sensor, the paper's, with a faint noise in the dark and nothing else;
    ``dvs_preset`` has real sensors. In the model ``carla``, which has no noise, that noise is 0.
    """

    model: DvsModel = "pedcross"
    positive_threshold: float = 0.3  # change of ln(light) that makes an event
    negative_threshold: float = 0.3
    sigma_threshold: float = 0.0  # spread between pixels (carla: between pixels and frames)
    refractory_ns: int = 0
    cutoff_hz: float = 0.0  # pole of the photoreceptor in full light (v2e: at grey level 255); 0: none
    cutoff_half_cd_m2: float = 50.0  # luminance at which the pole is half as fast (not v2e)
    leak_hz: float = 0.0  # ON events by which the reference leaks away, per pixel
    leak_spread_decades: float = 0.0  # spread of that rate between pixels, log10
    shot_hz: float = _DARK_NOISE_HZ  # noise events per pixel in the dark, both polarities together
    shot_half_cd_m2: float = (
        1.0  # luminance that halves their rate (v2e: a quarter is left at grey level 255)
    )
    hot_share: float = 0.0  # of pixels that fire by themselves
    hot_hz: float = 100.0  # median rate at which they do; half of them fire within a factor two of it
    bus_events_per_s: float | None = None  # what the readout can send; None: all
    bus_queue: int = 1024  # events that wait for it; further ones are lost
    log_floor_cd_m2: float = 0.01  # added to the radiance before the logarithm: dark current
    white_cd_m2: float = 1000.0  # luminance that 255 of an 8-bit frame stands for (pedcross)
    log_eps: float = 0.001  # CARLA's: added to 8-bit grey / 255 before the logarithm
    max_flow_px: float = 1.0  # image motion allowed between two renders
    max_streak: float = 16.0  # diameters that a 2 mm raindrop (a 5 mm flake) may fall between two renders
    max_subframes: int | None = 10  # per policy step, whatever asks for them; None: no cap
    layers: bool = True  # what is far, and moves less, is rendered more rarely, where the weather allows it

    def __post_init__(self) -> None:
        if self.model not in DVS_MODELS:
            raise unknown_name("event camera model", self.model, DVS_MODELS)
        for name in ("positive_threshold", "negative_threshold"):
            require(0.01 <= getattr(self, name) <= 10, name, getattr(self, name), "0.01 to 10")
        for name in ("sigma_threshold", "refractory_ns", "cutoff_hz", "leak_hz", "shot_hz", "hot_hz"):
            require(0 <= getattr(self, name) < float("inf"), name, getattr(self, name), "0 or more, finite")
        for name in (
            "cutoff_half_cd_m2",
            "shot_half_cd_m2",
            "log_floor_cd_m2",
            "white_cd_m2",
            "log_eps",
            "max_flow_px",
            "max_streak",
        ):
            require(0 < getattr(self, name) < float("inf"), name, getattr(self, name), "positive, finite")
        require(0 <= self.leak_spread_decades <= 1, "leak_spread_decades", self.leak_spread_decades, "0 to 1")
        require(0 <= self.hot_share <= 0.5, "hot_share", self.hot_share, "0 to 0.5")
        if self.bus_events_per_s is not None:
            require(self.bus_events_per_s > 0, "bus_events_per_s", self.bus_events_per_s, "positive, or None")
        require(self.bus_queue >= 1, "bus_queue", self.bus_queue, "1 or more")
        if self.max_subframes is not None:
            require(self.max_subframes >= 1, "max_subframes", self.max_subframes, "1 or more, or None")
        if self.model == "carla" and self.shot_hz == _DARK_NOISE_HZ:
            object.__setattr__(self, "shot_hz", 0.0)
        for name in _LACKS[self.model]:
            require(not getattr(self, name), name, getattr(self, name),
                    f"left out for model = {self.model!r}, which lacks it (model = 'pedcross' has it)")  # fmt: skip


def _camera(threshold: float, **more: Any) -> DvsConfig:
    return DvsConfig(positive_threshold=threshold, negative_threshold=threshold, **more)


DVS_PRESETS: Mapping[str, DvsConfig] = types.MappingProxyType(
    {
        "default": DvsConfig(),
        # Nothing but thresholds.
        "ideal": _camera(0.2, shot_hz=0.0),
        # What v2e (github.com/SensorsINI/v2e at cac6384) calls so, in our model.
        "clean": _camera(0.2, sigma_threshold=0.02, shot_hz=0.0),
        "noisy": _camera(0.2, sigma_threshold=0.05, cutoff_hz=30.0, leak_hz=0.1, leak_spread_decades=0.1, shot_hz=5.0),
        # CARLA's documentation, sensor.camera.dvs.
        "carla": DvsConfig(model="carla"),
        # v2e's own presets and the defaults of its command line.
        "v2e": _camera(0.2, model="v2e", sigma_threshold=0.03, cutoff_hz=300.0, leak_hz=0.01, leak_spread_decades=0.1,
                       shot_hz=0.001, refractory_ns=500_000),
        "v2e_clean": _camera(0.2, model="v2e", sigma_threshold=0.02, shot_hz=0.0),
        "v2e_noisy": _camera(0.2, model="v2e", sigma_threshold=0.05, cutoff_hz=30.0, leak_hz=0.1,
                             leak_spread_decades=0.1, shot_hz=5.0),
        # Lichtsteiner, Posch and Delbruck, JSSC 2008 (128x128), abstract: mismatch 2.1 % of contrast, pixel bandwidth
        # 3 kHz at 1 klux on the scene; slower in proportion to less light. Gallego et al., TPAMI 2022, table 1, from
        # memory: contrast 17 %, noise 0.05 events/pixel/s, 1 Meps. Refractory period, hot pixels: our choice.
        "dvs128": _camera(0.16, sigma_threshold=0.021, cutoff_hz=6000.0, cutoff_half_cd_m2=57.0, leak_hz=0.05,
                          leak_spread_decades=0.1, shot_hz=5.0, hot_share=1e-4, refractory_ns=100_000,
                          bus_events_per_s=1e6),
        # 346x260. Thresholds .2 +- .03, leak .2 Hz in bright light and shot noise of 10 Hz in dim light: the
        # DND21 data (Guo and Delbruck, TPAMI 2023). 12 Meps: Gallego et al., table 1, from memory. Pole, refractory
        # period and hot pixels are our choice.
        "davis346": _camera(0.2, sigma_threshold=0.03, cutoff_hz=1000.0, cutoff_half_cd_m2=20.0, leak_hz=0.2,
                            leak_spread_decades=0.1, shot_hz=10.0, hot_share=1e-4, refractory_ns=500_000,
                            bus_events_per_s=12e6),
        # A stacked 1280x720 sensor like Finateu et al., ISSCC 2020 (Prophesee Gen4, IMX636): 1.066 Geps in its title.
        # Contrast 11 %, latency 20-150 us, noise 0.1 events/pixel/s: Gallego et al., table 1, from memory. Twice the
        # contrast here, for the outdoors; 2 kHz is a latency of 80 us. Mismatch, shot noise, hot pixels: our choice.
        "gen4": _camera(0.22, sigma_threshold=0.02, cutoff_hz=2000.0, cutoff_half_cd_m2=10.0, leak_hz=0.05,
                        leak_spread_decades=0.1, shot_hz=5.0, hot_share=2e-5, refractory_ns=50_000,
                        bus_events_per_s=1.066e9, bus_queue=65536),
    }
)  # fmt: skip


def dvs_preset(name: str, **changes: Any) -> DvsConfig:
    """Return the event camera called ``name``, with some fields changed.

    Where a config is given as a mapping, ``{"dvs": "davis346"}`` and ``{"dvs": {"preset": "davis346",
    "max_subframes": None}}`` do the same.

    Args:
        name: One of DVS_PRESETS: default, ideal, clean, noisy, carla, v2e, v2e_clean, v2e_noisy, dvs128, davis346 and
            gen4; their sources are beside them.
        changes: Fields of DvsConfig.

    Raises:
        ConfigError: For an unknown name or field (names the nearest one), or a value out of range.
    """
    return changed_preset("event camera preset", DVS_PRESETS, name, changes)

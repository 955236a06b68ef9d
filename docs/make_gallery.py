"""Make the gallery: every weather preset and every camera, near and far: RGB | events | depth, for docs/gallery.md.

python docs/make_gallery.py [--only fog night ...]
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import cv2
import numpy as np

from eval.canvas import DEPTH_M, depth_colours
from pedcross_env.config import CAMERA_PRESETS, CameraConfig, EnvConfig, WindscreenConfig, camera_preset
from pedcross_env.env import CrossingEnv
from pedcross_env.sensors.events import counts_to_png
from pedcross_env.weather import WEATHERS, weather_by_name, weather_names

FOLDER = Path(__file__).parent / "gallery"
PAGE = FOLDER.parent / "gallery.md"
NEAR_M, FAR_M = (8.0, 11.0), (26.0, 30.0)
TUNNEL_M = (24.0, 12.0)  # before its exit, where there is a tunnel
EPISODES = 80
SETTLING_STEPS = 4  # for the exposure and the event camera, before the picture
OWN_PX, CARLA_PX, CAMERA_PX = 300, 225, 450  # width of one picture
JPEG_QUALITY = 82
WINDSCREENS = {
    "windscreen_rain": "rain",
    "windscreen_rain_night": "rain_night",
}  # pictures and their weathers

HEAD = """# Gallery

What the cameras see, for each preset: RGB, the events of one step (1/30 s; ON and OFF in colours of their own), and
depth ({low:g} m red to {high:g} m blue, logarithmic). Near is a pedestrian crossing {near:.0f} m ahead, far the same
crossing earlier (CARLA's presets and the cameras: near only; the tunnel: {before[0]:g} and {before[1]:g} m before its
exit). Made by `make gallery`.
"""


def moments() -> tuple[int, int, int]:
    """Seed of an episode, and its steps at which a crossing pedestrian is far off and near."""
    env = CrossingEnv(EnvConfig(modalities=()))
    for seed in range(EPISODES):
        env.reset(seed=seed)
        far, over, step = -1, False, 0
        while not over:
            *_, terminated, truncated, info = env.step(np.zeros(1, np.float32))
            over, step = terminated or truncated, step + 1
            if info["crossing"] and FAR_M[0] < info["distance_m"] < FAR_M[1]:
                far = step
            if info["crossing"] and far > 0 and NEAR_M[0] < info["distance_m"] < NEAR_M[1]:
                return seed, far, step
    raise SystemExit(f"no crossing seen from afar and near within {EPISODES} episodes")


def before_exit(seed: int, exit_m: float) -> tuple[int, ...]:
    """Steps of an episode at which the exit of a tunnel is TUNNEL_M ahead."""
    env = CrossingEnv(EnvConfig(modalities=()))
    env.reset(seed=seed)
    steps: list[int] = []
    step = 0
    while len(steps) < len(TUNNEL_M):
        *_, info = env.step(np.zeros(1, np.float32))
        step += 1
        if info["position_m"] > exit_m - TUNNEL_M[len(steps)]:
            steps.append(step)
    return tuple(steps)


def row(env: CrossingEnv, until: int) -> np.ndarray:
    """Drive on to a step and show its RGB picture, events and depth side by side, (H, 3 W, 3) uint8."""
    world, hz = env.world, env.config.world.policy_hz
    while round(world.time_s * hz) < until - SETTLING_STEPS:
        world.step(0.0)  # the cameras stay shut: nothing is rendered
    while round(world.time_s * hz) < until:
        observation, *_ = env.step(np.zeros(1, np.float32))
    return np.hstack(
        [observation["rgb"], counts_to_png(observation["dvs"]), depth_colours(env.truth().depth)]
    )


def save(name: str, picture: np.ndarray, width_px: int) -> Path:
    height_px = round(picture.shape[0] * width_px / picture.shape[1])
    small = cv2.resize(picture, (width_px, height_px), interpolation=cv2.INTER_AREA)
    path = FOLDER / f"{name}.jpg"
    cv2.imwrite(str(path), np.ascontiguousarray(small[..., ::-1]), [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    return path


def drive(
    weather: str,
    camera: CameraConfig,
    seed: int,
    steps: tuple[int, ...],
    windscreen: WindscreenConfig | None = None,
) -> np.ndarray:
    env = CrossingEnv(
        EnvConfig(weather=(weather,), camera=camera, windscreen=windscreen or WindscreenConfig())
    )
    env.reset(seed=seed)
    return np.vstack([row(env, step) for step in steps])


def weather_facts(name: str) -> str:
    weather = weather_by_name(name)
    facts = [f"sun {weather.sun_altitude_deg:.0f}°", f"clouds {100 * weather.cloudiness:.0f} %"]
    if math.isfinite(weather.visibility_m):
        facts.append(f"visibility {weather.visibility_m:.0f} m")
    if weather.rain_mm_h:
        facts.append(f"rain {weather.rain_mm_h:.0f} mm/h")
    if weather.snow_mm_h:
        facts.append(f"snow {weather.snow_mm_h:.0f} mm/h")
    return ", ".join([*facts, f"friction {weather.friction:.2f}"])


def camera_facts(camera: CameraConfig) -> str:
    return (
        f"{camera.width_px}x{camera.height_px}, {camera.horizontal_fov_deg:.0f}°, {camera.lens}, "
        f"{camera.mount_z_m} m high, pitch {camera.pitch_deg:g}°"
    )


def page() -> str:
    """The Markdown page of what is in the folder."""
    low, high = DEPTH_M
    lines = [
        HEAD.format(low=low, high=high, near=sum(NEAR_M) / 2, before=TUNNEL_M),
        "\n## Weather, near and far\n",
    ]
    for name in weather_names():
        if name not in WEATHERS and name == next(n for n in weather_names() if n not in WEATHERS):
            lines.append("\n## CARLA's presets\n")
        if (FOLDER / f"{name}.jpg").exists():
            lines.append(f"\n**{name}**: {weather_facts(name)}\n\n![{name}](gallery/{name}.jpg)\n")
    lines.append("\n## Drops on the windscreen (an option)\n")
    for name, weather in WINDSCREENS.items():
        if (FOLDER / f"{name}.jpg").exists():
            lines.append(
                f"\n**{weather}** with `windscreen={{'drops': True}}`\n\n![{name}](gallery/{name}.jpg)\n"
            )
    lines.append("\n## Cameras\n")
    for name, camera in CAMERA_PRESETS.items():
        if (FOLDER / f"camera_{name}.jpg").exists():
            lines.append(f"\n**{name}**: {camera_facts(camera)}\n\n![{name}](gallery/camera_{name}.jpg)\n")
    return "".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", nargs="*", default=None, help="weather presets or cameras to make again")
    args = parser.parse_args()
    FOLDER.mkdir(exist_ok=True)
    seed, far, near = moments()
    for name in weather_names():
        if args.only is None or name in args.only:
            own, exit_m = name in WEATHERS, weather_by_name(name).tunnel_exit_m
            steps = (far, near) if own else (near,)
            if math.isfinite(exit_m):
                steps = before_exit(seed, exit_m)
            picture = drive(name, CameraConfig(), seed, steps)
            print(save(name, picture, 3 * (OWN_PX if own else CARLA_PX)))
    for name, weather in WINDSCREENS.items():
        if args.only is None or name in args.only:
            picture = drive(weather, CameraConfig(), seed, (near,), WindscreenConfig(drops=True))
            print(save(name, picture, 3 * OWN_PX))
    for name in CAMERA_PRESETS:
        if (
            args.only is None or name in args.only
        ) and name != "pie":  # as pie_small, but sixteen times the pixels
            print(
                save(
                    f"camera_{name}",
                    drive("clear", camera_preset(name), seed, (near,)),
                    3 * CAMERA_PX * 2 // 3,
                )
            )
    PAGE.write_text(page())
    total = sum(path.stat().st_size for path in FOLDER.glob("*.jpg"))
    print(f"{PAGE}: episode {seed}, steps {far} and {near}; {total / 1e6:.2f} MB of pictures")


if __name__ == "__main__":
    main()

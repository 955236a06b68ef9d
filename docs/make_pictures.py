"""Make the README's picture: the driver's view, events and the street from above, in four kinds of weather.

python docs/make_pictures.py
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from pedcross_env.env import CrossingEnv
from pedcross_env.sensors.events import counts_to_png

WEATHERS = ("clear", "fog", "rain", "night")
EPISODES = 40


def best_moment(weather: str) -> tuple[int, int]:
    """Seed and step at which a crossing pedestrian is large in view, found without any camera."""
    env = CrossingEnv({"modalities": (), "weather": (weather,)})
    for seed in range(EPISODES):
        env.reset(seed=seed)
        over, step = False, 0
        while not over:
            *_, terminated, truncated, info = env.step(np.zeros(1, np.float32))
            over, step = terminated or truncated, step + 1
            if info["crossing"] and 9 < info["distance_m"] < 12:
                return seed, step
    raise SystemExit(f"no crossing in view within {EPISODES} episodes")


def row(weather: str, seed: int, steps: int) -> np.ndarray:
    env = CrossingEnv({"weather": (weather,)})
    env.reset(seed=seed)
    for _ in range(steps):
        observation, *_ = env.step(np.zeros(1, np.float32))
    above = env.birds_eye()
    height = observation["rgb"].shape[0]
    above = cv2.rotate(above, cv2.ROTATE_90_CLOCKWISE)
    above = cv2.resize(
        above, (round(above.shape[1] * height / above.shape[0]), height), interpolation=cv2.INTER_AREA
    )
    return np.hstack([observation["rgb"], counts_to_png(observation["dvs"]), above])


def main() -> None:
    seed, steps = best_moment("clear")
    picture = np.vstack([row(weather, seed, steps) for weather in WEATHERS])
    path = Path(__file__).parent / "street.jpg"
    cv2.imwrite(str(path), np.ascontiguousarray(picture[..., ::-1]), [cv2.IMWRITE_JPEG_QUALITY, 88])
    print(f"{path}: episode {seed}, step {steps}")


if __name__ == "__main__":
    main()

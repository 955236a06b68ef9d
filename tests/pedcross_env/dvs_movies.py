"""Movies and players that the tests of the event camera share."""

from __future__ import annotations

import numpy as np

from pedcross_env.sensors.dvs import DvsState, initial_state, step
from pedcross_env.sensors.dvs_config import DvsConfig

STEP_NS = 33_333_333
f32 = np.float32


def config(threshold: float = 0.3, **changes: object) -> DvsConfig:
    values = {"positive_threshold": threshold, "negative_threshold": threshold, "shot_hz": 0.0}
    return DvsConfig(**(values | changes))  # type: ignore[arg-type]


def smooth_sequence(seed: int, frames: int = 8, shape: tuple[int, int] = (12, 17)) -> np.ndarray:
    """Smooth random log-luminance movie, float32."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[: shape[0], : shape[1]]
    movie = np.zeros((frames, *shape))
    for _ in range(12):
        a, b, c, d = rng.normal(0, 0.4), rng.normal(0, 0.4), rng.uniform(0, 6.3), rng.normal(0, 1.2)
        movie += 0.4 * np.sin(a * x + b * y + c + d * np.arange(frames)[:, None, None])
    return movie.astype(f32)


def play(
    movie: np.ndarray, camera: DvsConfig, seed: int = 3, step_ns: int = STEP_NS
) -> tuple[DvsState, list[np.ndarray]]:
    state, found = initial_state(movie[0], 0, camera, seed), []
    for k, frame in enumerate(movie[1:], 1):
        state, events = step(state, frame, k * step_ns, camera)
        found.append(events)
    return state, found

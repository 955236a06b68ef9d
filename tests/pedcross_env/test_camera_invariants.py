"""What holds for every picture: the same bytes in any process, no popping, sky only above the horizon."""

import itertools
import os
import subprocess
import sys

import numpy as np
import pytest
from camera_scenes import pedestrian, renderer, snapshot, vehicle

from pedcross_env.contracts import StaticClass

DIGEST = """
import hashlib
import numpy as np
from pedcross_env.env import CrossingEnv
env = CrossingEnv({"weather": ["rain_night"], "camera": {"width_px": 96, "height_px": 56}})
env.reset(seed=5)
digest = hashlib.sha256()
for k in range(4):
    observation, *_ = env.step(np.array([-0.3], np.float32))
    digest.update(observation["rgb"].tobytes() + observation["dvs"].tobytes())
truth = env.truth()
digest.update(truth.depth.tobytes() + truth.instance.tobytes())
print(digest.hexdigest())
"""


def digest(**environment):
    run = subprocess.run(
        [sys.executable, "-c", DIGEST],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=True,
    )
    return run.stdout.split()[-1]


def test_pictures_events_and_truth_are_the_same_bytes_in_two_processes():
    assert digest(OMP_NUM_THREADS="1", PYTHONHASHSEED="1") == digest(OMP_NUM_THREADS="2", PYTHONHASHSEED="2")


@pytest.mark.parametrize(
    "other", [vehicle(4, 12.0, 0.05), pedestrian(5, 12.0, -2.25)], ids=["car", "pedestrian"]
)
def test_an_actor_that_passes_beside_the_camera_does_not_pop(other):
    """Every centimetre of way changes the picture about as much as the centimetres before and after it."""
    camera = renderer(width_px=150, height_px=86)
    pictures = [
        camera.render(snapshot(other, x=x), luminance_only=True).luminance
        for x in np.arange(11.0, 12.4, 0.01)
    ]
    jumps = [float(np.mean(np.abs(b - a) / a.mean())) for a, b in itertools.pairwise(pictures)]
    around = [max(jumps[max(0, k - 2) : k] + jumps[k + 1 : k + 3]) for k in range(len(jumps))]
    assert max(jumps) < 0.06
    assert all(jump < 3.0 * neighbour + 0.004 for jump, neighbour in zip(jumps, around, strict=True))


@pytest.mark.parametrize("pitch", [-0.06, 0.0, 0.08])
def test_there_is_no_sky_below_the_horizon(pitch):
    camera = renderer(width_px=150, height_px=86)
    rng = np.random.default_rng(3)
    for _ in range(6):
        x, yaw = rng.uniform(-20.0, 120.0), rng.uniform(-0.5, 0.5)
        frame = camera.render(snapshot(vehicle(4, x + 9.0, 1.0), x=x, yaw=yaw, pitch=pitch))
        horizon = 43 - camera.config.focal_px * np.tan(pitch)
        below = frame.instance[int(np.ceil(horizon)) + 1 :]
        assert (below != StaticClass.SKY).all()
        assert np.isfinite(frame.depth[int(np.ceil(horizon)) + 1 :]).all()

"""What rendering the scene in layers changes: events against those of many more renders, and CPU time.

    python benchmarks/layers.py [--seeds 4] [--steps 15]

The ego drives at 10 m/s in clear weather, with the event camera alone. The reference is the whole scene, rendered so
often that the image moves by at most a quarter of a pixel. With a and b the sums of the events' signs per pixel and
step,

    mismatch = sum |a - b| / sum |b|.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import numpy as np
from machine import cpu_name

from pedcross_env.env import CrossingEnv

REFERENCE = {"max_flow_px": 0.25, "max_subframes": None, "layers": False}
CASES: dict[str, dict[str, Any]] = {
    "1 px, whole scene": {"max_subframes": None, "layers": False},
    "1 px, layers": {"max_subframes": None},
    "ten renders, whole scene": {"layers": False},
    "ten renders, layers": {},
}


def drive(settings: dict[str, Any], seeds: int, steps: int) -> tuple[np.ndarray, float]:
    """(steps, H, W) signed counts, and CPU ms per step."""
    env = CrossingEnv(
        {"modalities": ("dvs",), "weather": ("clear",), "traffic": {"ego_speed_mps": (10.0, 10.0)},
         "dvs": {"shot_hz": 0.0} | settings}
    )  # fmt: skip
    signed, spent_s = [], 0.0
    for seed in range(seeds):
        env.reset(seed=seed)
        for _ in range(steps):
            start = time.process_time()
            counts = env.step(np.zeros(1, np.float32))[0]["dvs"].astype(np.int32)
            spent_s += time.process_time() - start
            signed.append(counts[..., 0] - counts[..., 1])
    return np.array(signed), 1e3 * spent_s / len(signed)


def mismatch(found: np.ndarray, reference: np.ndarray) -> float:
    return float(np.abs(found - reference).sum() / np.abs(reference).sum())


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--steps", type=int, default=15, help="policy steps per seed")
    arguments = parser.parse_args()
    drive({}, 1, 2)  # compiles
    reference, _ = drive(REFERENCE, arguments.seeds, arguments.steps)
    print(f"CPU: {cpu_name()}; 450x256, {arguments.seeds} seeds of {arguments.steps} steps")
    print(f"{'':26s}{'mismatch to .25 px':>20s}{'to 1 px, whole':>20s}{'CPU ms per step':>20s}")
    whole = None
    for name, settings in CASES.items():
        found, ms = drive(settings, arguments.seeds, arguments.steps)
        whole = found if whole is None else whole
        print(f"{name:26s}{mismatch(found, reference):20.4f}{mismatch(found, whole):20.4f}{ms:20.1f}")


if __name__ == "__main__":
    main()

"""Policy steps of the environment per CPU-second, one process, after warm-up.

    python benchmarks/environment.py [--steps 150]

Real time is 30 steps per second.
"""

import argparse
import platform
import time

import numpy as np

from pedcross_env.env import CrossingEnv

CASES = [((), "clear"), (("rgb",), "clear"), (("dvs",), "clear"), (("rgb", "dvs"), "clear"), (("rgb", "dvs"), "fog"),
         (("rgb", "dvs"), "rain"), (("rgb", "dvs"), "night")]  # fmt: skip


def cpu_name() -> str:
    try:
        with open("/proc/cpuinfo") as lines:
            return next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except OSError:
        return platform.processor()


def rate(modalities: tuple[str, ...], weather: str, steps: int) -> tuple[float, float]:
    env = CrossingEnv({"modalities": modalities, "weather": (weather,)})
    hold = np.zeros(1, np.float32)
    env.reset(seed=0)
    for _ in range(5):
        env.step(hold)
    spent, done, subframes, seed = 0.0, 0, 0, 0
    while done < steps:
        seed += 1
        env.reset(seed=seed)
        begin, over = time.process_time(), False
        while not over and done < steps:
            *_, terminated, truncated, info = env.step(hold)
            over, done = terminated or truncated, done + 1
            subframes += info["subframes"]
        spent += time.process_time() - begin
    return done / spent, subframes / done


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=150)
    steps = parser.parse_args().steps
    print(f"CPU: {cpu_name()}; 450x256, {steps} steps each")
    for modalities, weather in CASES:
        steps_per_s, subframes = rate(modalities, weather, steps)
        name = " + ".join(modalities) or "no camera"
        print(f"{name:12s} {weather:6s} {steps_per_s:9.1f} steps/s  {steps_per_s / 30:6.2f} x real time  "
              f"{subframes:4.1f} renders for events per step")  # fmt: skip


if __name__ == "__main__":
    main()

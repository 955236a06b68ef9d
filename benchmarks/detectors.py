"""Milliseconds per window, per streamed frame and per training step of every network.

    python benchmarks/detectors.py [--threads 1] [--models sps_r18t pt_resnet18] [--sizes 112x64@0.25]

Times are of the processor (user + system, all threads), so other work on the machine hardly counts.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np
import torch
from rich.console import Console
from rich.table import Table

from perception.models.spiking import fresh_state
from perception.preprocess import Preprocess
from perception.registry import NETWORKS, create_network
from perception.streaming import NetworkDetector, clip_tensor

FRAMES, BATCH = 9, 8


def milliseconds(work: Callable[[], object], seconds: float) -> float:
    """Return the median processor time of ``work``, after one run to warm up."""
    work()
    times: list[float] = []
    while sum(times) < seconds or len(times) < 3:
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return 1e3 * float(np.median(times))


def measure(
    model: str, width_px: int, height_px: int, width: float, precision: str, seconds: float
) -> list[float]:
    """Return ms per window, per streamed frame (with preprocessing from 450x256) and per training step."""
    view = Preprocess.compact("dvs", width_px, height_px)
    network = create_network(model, in_channels=view.channels, frames=FRAMES, width=width)
    detector = NetworkDetector(network, view, name=model, frames=FRAMES)
    rng = np.random.default_rng(0)
    small = rng.integers(0, 255, (BATCH, FRAMES, height_px, width_px, view.channels), dtype=np.uint8)
    observation = {"dvs": rng.integers(0, 3, (256, 450, 2), dtype=np.uint8)}

    def window() -> None:
        with torch.inference_mode(), fresh_state(network):
            network(clip_tensor(small[:1], view))

    def step() -> None:
        with fresh_state(network):
            with torch.autocast("cpu", torch.bfloat16, enabled=precision == "bf16"):
                logits = network(clip_tensor(small, view)).float()
            logits.sum().backward()

    network.train()
    training = milliseconds(step, seconds)
    network.eval()
    return [
        milliseconds(window, seconds),
        milliseconds(lambda: detector.update(observation), seconds),
        training,
    ]


def main() -> None:
    """Measure what the command line asks for and print a table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--models", nargs="+", default=list(NETWORKS), choices=list(NETWORKS))
    parser.add_argument("--sizes", nargs="+", default=["112x64@0.25"], help="WIDTHxHEIGHT@width multiplier")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--precision", choices=["fp32", "bf16"], default="fp32", help="of the training step")
    parser.add_argument("--seconds", type=float, default=0.5, help="spent on each number")
    arguments = parser.parse_args()
    torch.set_num_threads(arguments.threads)
    table = Table(title=f"T = {FRAMES}, {arguments.threads} threads, training {arguments.precision}")
    for column in ("network", "size", "window ms", "streamed frame ms", f"training step of {BATCH} ms"):
        table.add_column(column, justify="right")
    for size in arguments.sizes:
        pixels, width = size.split("@")
        width_px, height_px = (int(v) for v in pixels.split("x"))
        for model in arguments.models:
            row = measure(model, width_px, height_px, float(width), arguments.precision, arguments.seconds)
            table.add_row(model, size, *(f"{value:.1f}" for value in row))
    Console().print(table)


if __name__ == "__main__":
    main()

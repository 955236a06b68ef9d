"""Where a detector sees and where it does not: AUROC by the ego's speed and by how far off the pedestrian is.

One number over all clips hides that most of it may come from a walker before a standing camera. The facts are those of
the recorder's manifest; data without one gives no rows.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from eval import metrics
from eval.statistics import clustered_bootstrap
from pedcross_env.errors import DataError

__all__ = ["DISTANCES_M", "SPEEDS_MPS", "clip_facts", "strata"]

SPEEDS_MPS = (0.0, 0.5, 4.0, 8.0, math.inf)
DISTANCES_M = (0.0, 8.0, 16.0, 24.0, 32.0, math.inf)
RESAMPLES = 200
_COLUMNS = ["subset", "video", "frame", "speed_mps", "distance_m", "crossing"]

Row = dict[str, Any]


@dataclass(frozen=True, slots=True)
class ClipFacts:
    """What happened during each of N clips.

    Attributes:
        speed_mps: (N,) mean speed of the ego.
        distance_m: (N,) to the nearest labelled pedestrian while one is labelled; inf in negative clips.
    """

    speed_mps: np.ndarray
    distance_m: np.ndarray


def strata(clips: Sequence[Row], manifest: Path, *, seed: int = 0) -> list[Row]:
    """One row per detector and stratum, all subsets together.

    A stratum of speed holds the clips of both classes at that speed. One of distance holds the positive clips with the
    pedestrian that far off, and all negative ones.

    Args:
        clips: Rows of ``eval.offline.benchmark``.
        manifest: The dataset's manifest.parquet; where there is none, there are no rows.
        seed: Of the bootstrap over videos.

    Returns:
        Rows with detector, by ("speed_mps" or "distance_m"), from, to, clips, positives, auroc, auroc_low, auroc_high;
        nan where a class is missing.

    Raises:
        DataError: For a damaged manifest, or one that lacks frames of the clips.
    """
    if not clips or not manifest.exists():
        return []
    facts = clip_facts(clips, manifest)
    names = np.array([row["detector"] for row in clips])
    labels = np.array([row["label"] for row in clips], np.int64)
    p = np.array([row["p"] for row in clips], np.float64)
    videos = np.array([f"{row['subset']}/{row['video']}" for row in clips])
    rows = []
    for name in dict.fromkeys(names.tolist()):
        for by, edges in (("speed_mps", SPEEDS_MPS), ("distance_m", DISTANCES_M)):
            values = getattr(facts, by)
            for low, high in pairwise(edges):
                inside = (values >= low) & (values < high)
                if by == "distance_m":
                    inside |= labels == 0
                inside &= names == name
                scores = _scores(labels[inside], p[inside], videos[inside], seed)
                rows.append({"detector": name, "by": by, "from": low, "to": high, **scores})
    return rows


def _scores(labels: np.ndarray, p: np.ndarray, videos: np.ndarray, seed: int) -> Row:
    interval = clustered_bootstrap(
        lambda weights: metrics.auroc(labels, p, weights), videos, seed=seed, resamples=RESAMPLES
    )
    return {
        "clips": int(labels.size),
        "positives": int(labels.sum()),
        "auroc": metrics.auroc(labels, p),
        "auroc_low": interval.low,
        "auroc_high": interval.high,
    }


def clip_facts(clips: Sequence[Row], manifest: Path) -> ClipFacts:
    """Look the clips' frames up in the manifest; see ``strata`` for arguments and errors."""
    try:
        table = pq.read_table(manifest, columns=_COLUMNS)
    except (pa.ArrowException, OSError) as error:
        raise DataError(f"{manifest}: damaged manifest ({error}); record the data again.") from error
    columns = {name: table.column(name).to_numpy() for name in _COLUMNS}
    row_of = {
        (subset, video, int(frame)): i
        for i, (subset, video, frame) in enumerate(
            zip(columns["subset"], columns["video"], columns["frame"], strict=True)
        )
    }
    distance = np.where(columns["crossing"] > 0, columns["distance_m"], np.inf)
    speeds, distances = np.empty(len(clips)), np.empty(len(clips))
    for i, clip in enumerate(clips):
        frames = range(clip["start_frame"], clip["start_frame"] + clip["frames"])
        try:
            rows = [row_of[clip["subset"], clip["video"], frame] for frame in frames]
        except KeyError as error:
            raise DataError(f"{manifest} lacks the frame {error}; record the data again.") from error
        speeds[i], distances[i] = columns["speed_mps"][rows].mean(), distance[rows].min()
    return ClipFacts(speeds, distances)

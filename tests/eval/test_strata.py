"""AUROC by speed and distance, from a manifest written by hand."""

import math

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from eval.strata import DISTANCES_M, SPEEDS_MPS, clip_facts, strata
from pedcross_env.errors import DataError


def frame(video, number, *, speed=10.0, crossing=0, distance=math.inf):
    return {
        "subset": "default", "video": video, "frame": number, "speed_mps": speed, "crossing": crossing,
        "distance_m": distance,
    }  # fmt: skip


def clip(video, label, p, start=0, detector="mine"):
    return {
        "detector": detector, "subset": "default", "video": video, "start_frame": start, "frames": 2,
        "label": label, "p": p,
    }  # fmt: skip


def write(path, frames):
    pq.write_table(pa.Table.from_pylist(frames), path)
    return path


@pytest.fixture
def manifest(tmp_path):
    """Two standing and two driving videos; in one of either kind somebody crosses, 5 m and 30 m ahead."""
    frames = []
    for n in range(2):
        frames += [
            frame("stands-empty", n, speed=0.0),
            frame("stands", n, speed=0.0, crossing=n, distance=5.0),
            frame("drives-empty", n, speed=9.0 + n, distance=3.0),  # of nobody labelled: says nothing
            frame("drives", n, speed=10.0, crossing=1, distance=31.0 - n),
        ]
    return write(tmp_path / "manifest.parquet", frames)


CLIPS = [
    clip("stands-empty", 0, 0.2), clip("stands", 1, 0.9), clip("drives-empty", 0, 0.6), clip("drives", 1, 0.4),
]  # fmt: skip


def found(rows, by):
    return {row["from"]: row for row in rows if row["by"] == by}


def test_facts_are_the_mean_speed_and_the_nearest_labelled_pedestrian(manifest):
    facts = clip_facts(CLIPS, manifest)
    assert facts.speed_mps.tolist() == [0.0, 0.0, 9.5, 10.0]
    assert facts.distance_m.tolist() == [math.inf, 5.0, math.inf, 30.0]


def test_a_detector_of_walkers_before_a_standing_car_is_found_out(manifest):
    rows = strata(CLIPS, manifest)
    assert len(rows) == len(SPEEDS_MPS) - 1 + len(DISTANCES_M) - 1
    speed, distance = found(rows, "speed_mps"), found(rows, "distance_m")
    assert (speed[0.0]["auroc"], speed[8.0]["auroc"]) == (1.0, 0.0)
    assert (speed[8.0]["clips"], speed[8.0]["positives"]) == (2, 1)
    # near: .9 against .2 and .6; far: .4 against them
    assert (distance[0.0]["auroc"], distance[24.0]["auroc"]) == (1.0, 0.5)
    assert (distance[24.0]["clips"], distance[24.0]["positives"]) == (3, 1)


def test_an_empty_stratum_has_no_score(manifest):
    row = found(strata(CLIPS, manifest), "speed_mps")[4.0]
    assert (row["clips"], row["positives"]) == (0, 0)
    assert math.isnan(row["auroc"])


def test_detectors_are_kept_apart(manifest):
    better = [{**row, "detector": "better", "p": float(row["label"])} for row in CLIPS]
    rows = [row for row in strata([*CLIPS, *better], manifest) if row["by"] == "speed_mps"]
    assert {row["detector"]: row["auroc"] for row in rows if row["from"] == 8.0} == {
        "mine": 0.0,
        "better": 1.0,
    }


def test_data_without_a_manifest_has_no_strata(tmp_path):
    assert strata(CLIPS, tmp_path / "manifest.parquet") == []


def test_a_manifest_that_does_not_fit_the_clips_is_an_error(manifest, tmp_path):
    with pytest.raises(DataError, match=r"lacks the frame .*'drives', 2"):
        strata([clip("drives", 1, 0.5, start=1)], manifest)
    damaged = tmp_path / "damaged.parquet"
    damaged.write_bytes(manifest.read_bytes()[:-20])
    with pytest.raises(DataError, match="damaged manifest"):
        strata(CLIPS, damaged)

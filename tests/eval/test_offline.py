import cv2
import numpy as np
import pytest
from fake_world import FakeDetector
from sklearn.metrics import roc_auc_score

from eval.detectors import DetectorSpec
from eval.offline import BenchmarkConfig, benchmark
from eval.store import read_rows
from pedcross_env.errors import ConfigError, DataError


def write_video(root, name, labels, values, subset="default"):
    """A video of uniform 8x8 images of the given grey values."""
    folder = root / f"{subset}_rgb" / name
    folder.mkdir(parents=True)
    for i, (label, value) in enumerate(zip(labels, values, strict=True)):
        assert cv2.imwrite(str(folder / f"{i}-{label}.png"), np.full((8, 8, 3), value, np.uint8))


def spec(name="sharp", **changes):
    facts: dict = {"braking_threshold": 0.9} | {
        "name": name,
        "path": name,
        "modality": "rgb",
        "threshold": 0.5,
        "fingerprint": "f",
    }
    return DetectorSpec(**(facts | changes))


def run(root, specs=None, **changes):
    config = BenchmarkConfig(**({"data": root / "data", "out": root / "out", "stride": 1} | changes))
    return benchmark(config, specs=specs or [spec()], loader=FakeDetector)


@pytest.fixture
def two_videos(tmp_path):
    rng = np.random.default_rng(0)
    for i in range(4):
        labels = [0] * 6 + [1] * 5 * (i % 2)
        write_video(tmp_path / "data", f"video_{i}", labels, rng.integers(0, 250, len(labels)))
    return tmp_path


def test_rows_are_windows_with_the_label_of_any_positive_frame(two_videos):
    report = run(two_videos)
    assert len(report.clips) == 2 * 4 + 2 * 9
    by_start = {r["start_frame"]: r["label"] for r in report.clips if r["video"] == "video_1"}
    assert by_start == {s: int(s + 2 >= 6) for s in range(9)}
    assert read_rows(two_videos / "out" / "clips.parquet") == report.clips


def test_scores_are_those_of_the_rows(two_videos):
    report = run(two_videos)
    labels, p = [r["label"] for r in report.clips], [r["p"] for r in report.clips]
    row = report.table[0]
    assert row["auroc"] == pytest.approx(roc_auc_score(labels, p))
    assert row["auroc_low"] <= row["auroc"] <= row["auroc_high"]
    assert (row["clips"], row["positives"], row["videos"], row["positive_videos"]) == (26, sum(labels), 4, 2)


@pytest.mark.parametrize("stride", [1, 2, 3, 5])
def test_stride_is_the_distance_of_starts(two_videos, stride):
    starts = [r["start_frame"] for r in run(two_videos, stride=stride).clips if r["video"] == "video_3"]
    assert starts == list(range(0, 9, stride))


def test_one_class_is_nan_with_its_reason(tmp_path):
    for i in range(3):
        write_video(tmp_path / "data", f"video_{i}", [0] * 5, [10] * 5)
    row = run(tmp_path).table[0]
    assert all(np.isnan(row[key]) for key in ("auroc", "auroc_low", "auprc", "f_score"))
    assert row["note"] == "one class only: all 9 clips are negative"


def test_videos_too_short_for_a_clip_are_counted_not_scored(tmp_path):
    write_video(tmp_path / "data", "video_0", [0, 1], [1, 2])
    row = run(tmp_path).table[0]
    assert (row["clips"], row["short_videos"]) == (0, 1)
    assert np.isnan(row["auroc"])
    assert row["note"] == "no clip could be cut"


def test_a_truncated_image_stops_the_run_or_costs_its_clips(two_videos):
    image = two_videos / "data" / "default_rgb" / "video_0" / "2-0.png"
    image.write_bytes(image.read_bytes()[:20])
    with pytest.raises(DataError, match=r"2-0\.png.*--on-error skip"):
        run(two_videos)
    row = run(two_videos, on_error="skip").table[0]
    assert (row["damaged_images"], row["lost_clips"], row["clips"]) == (1, 3, 23)
    assert "2-0.png" in row["first_error"]


def test_clips_do_not_span_a_missing_frame(two_videos):
    (two_videos / "data" / "default_rgb" / "video_0" / "2-0.png").unlink()
    row = run(two_videos).table[0]
    assert (row["clips"], row["lost_clips"]) == (23, 2)


def test_the_test_split_is_what_training_kept_apart(two_videos):
    kept = spec(test_videos=("default/video_3", "default/video_2"))
    assert {r["video"] for r in run(two_videos, [kept], split="test").clips} == {"video_2", "video_3"}
    with pytest.raises(ConfigError, match="--split all"):
        run(two_videos, [spec()], split="test")
    with pytest.raises(DataError, match="test videos"):
        run(two_videos, [spec(test_videos=("default/other",))], split="test")


def test_unknown_subset_names_the_nearest(two_videos):
    with pytest.raises(ConfigError, match="Did you mean 'default'"):
        run(two_videos, subsets=("defualt",))


def test_missing_data_is_named(tmp_path):
    with pytest.raises(DataError, match="is not a folder"):
        run(tmp_path)
    (tmp_path / "data").mkdir()
    with pytest.raises(DataError, match="no folder"):
        run(tmp_path)

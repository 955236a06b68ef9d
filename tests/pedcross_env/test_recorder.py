"""Datasets: layout, resumption, refusals."""

import hashlib
from pathlib import Path

import cv2
import numpy as np
import pyarrow.parquet as pq
import pytest

from pedcross_env.config import CameraConfig, TrafficConfig
from pedcross_env.errors import ConfigError
from pedcross_env.recorder import GenerateConfig, generate, recording_actions
from pedcross_env.sensors.events import png_to_counts


def config(out: Path, **settings) -> GenerateConfig:
    camera = CameraConfig(width_px=48, height_px=32)
    return GenerateConfig(
        out=out, videos=2, workers=1, camera=camera, traffic=TrafficConfig(duration_s=1.0), **settings
    )


def digests(root: Path) -> dict[str, str]:
    return {
        str(path.relative_to(root)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(root.rglob("*"))
        if path.suffix in (".jpg", ".png", ".npz")
    }


@pytest.fixture(scope="module")
def dataset(tmp_path_factory) -> Path:
    root = tmp_path_factory.mktemp("dataset")
    generate(config(root, events=True, event_causes=True))
    return root


def test_layout_is_the_papers(dataset):
    folders = sorted(p.name for p in dataset.iterdir() if p.is_dir() and p.name != "manifest")
    assert folders == [
        "default_dvs", "default_events", "default_rgb", "weather_dvs", "weather_events", "weather_rgb",
    ]  # fmt: skip
    table = pq.read_table(dataset / "manifest.parquet").to_pylist()
    assert {row["subset"] for row in table} == {"default", "weather"}
    for row in table:
        assert Path(row["rgb"]).name == f"{row['frame']}-{row['crossing']}.jpg"
        assert (dataset / row["rgb"]).is_file()
        assert (dataset / row["dvs"]).is_file()
    assert {row["weather"] for row in table if row["subset"] == "default"} == {"clear"}


def test_png_holds_the_counts_of_the_raw_events(dataset):
    events = np.load(dataset / "default_events" / "video_0000.npz")["events"]
    total = sum(
        int(png_to_counts(cv2.imread(str(path))[..., ::-1]).sum())
        for path in (dataset / "default_dvs" / "video_0000").iterdir()
    )
    assert total == len(events)


def test_every_recorded_event_has_its_cause(dataset):
    for path in sorted(dataset.glob("*_events/*.npz")):
        causes = np.load(path.with_name(f"{path.stem}_causes.npy"))
        assert causes.dtype == np.int32
        assert len(causes) == len(np.load(path)["events"])


def test_recordings_never_let_the_image_move_by_more_than_a_pixel_between_renders(dataset):
    table = pq.read_table(dataset / "manifest.parquet").to_pylist()
    assert max(row["flow_px"] for row in table) <= 1.0
    assert max(row["subframes"] for row in table) > 2


def test_a_rerun_records_nothing_and_completes_what_is_missing_bit_for_bit(dataset):
    before = digests(dataset)
    kept = (
        dataset / "default_rgb" / "video_0001" / next((dataset / "default_rgb" / "video_0001").iterdir()).name
    )
    stamp = kept.stat().st_mtime_ns
    assert generate(config(dataset, events=True, event_causes=True)).recorded == 0
    lost = [p for p in sorted((dataset / "default_rgb" / "video_0001").iterdir()) if p != kept][:3]
    for path in lost:
        path.unlink()
    (dataset / "manifest" / "weather-video_0000.parquet").unlink()
    leftover = dataset / "weather_rgb" / "video_0000" / ".99-3-0.jpg"
    leftover.write_bytes(b"half an im")
    report = generate(config(dataset, events=True, event_causes=True))
    assert (report.recorded, report.already_there) == (2, 2)
    assert not leftover.exists()
    assert digests(dataset) == before
    assert kept.stat().st_mtime_ns == stamp


def test_other_settings_do_not_mix_into_a_dataset(dataset):
    with pytest.raises(ConfigError, match="seed: 0 there, 5 asked for"):
        generate(config(dataset, events=True, event_causes=True, seed=5))


def test_other_code_does_not_add_to_a_dataset(dataset, monkeypatch):
    monkeypatch.setattr("pedcross_env.recorder.source_digest", lambda: "0123456789abcdef")
    with pytest.raises(
        ConfigError, match=r"made by other code of pedcross .source: '[0-9a-f]{16}' there, '0123456789abcdef'"
    ):
        generate(config(dataset, events=True, event_causes=True))


def test_unwritable_root_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigError, match="cannot be written"):
        generate(config(tmp_path / "file" / "data"))


def test_unknown_subset_names_the_nearest(tmp_path):
    with pytest.raises(ConfigError, match="'weather'"):
        config(tmp_path, subsets=("wether",))


def test_the_recording_driver_is_blind_and_seeded():
    first, again, other = (recording_actions(seed, 300, 30) for seed in (1, 1, 2))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)
    many = np.concatenate([recording_actions(seed, 300, 30) for seed in range(20)])
    assert 0.1 < np.mean(many < 0) < 0.4
    assert 0.1 < np.mean(many > 0) < 0.4

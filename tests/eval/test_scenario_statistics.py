"""Figures of random crossings, and JAAD's annotations beside them."""

from pathlib import Path

import numpy as np
import pytest

from eval import cli
from eval.jaad import read_video, read_videos
from eval.scenario_statistics import ScenariosConfig, measure
from pedcross_env.config import TrafficConfig, camera_preset
from pedcross_env.errors import ConfigError, DataError

ANNOTATIONS = Path(__file__).parents[2] / "../shared/realdata/jaad/annotations"
real = pytest.mark.skipif(not ANNOTATIONS.is_dir(), reason="JAAD's annotations are not here")

# frames and runs of positive frames (both ends included) of videos at hand
FACTS = {
    "video_0007": (120, [(32, 53)]), "video_0013": (150, []), "video_0024": (210, [(77, 193)]),
    "video_0036": (300, []), "video_0066": (330, [(91, 251)]), "video_0162": (120, [(0, 66)]),
    "video_0205": (210, [(133, 209)]), "video_0207": (60, []), "video_0243": (180, [(77, 163)]),
    "video_0246": (240, []), "video_0273": (120, [(43, 119)]), "video_0319": (120, [(4, 25), (53, 119)]),
}  # fmt: skip


@real
def test_jaad_is_read_as_it_is():
    for video in read_videos(ANNOTATIONS):
        frames, runs = FACTS[video.name]
        assert video.frames == frames
        assert video.positive == {k for first, last in runs for k in range(first, last + 1)}
        assert all(0 < height <= 1080 for height in video.onset_heights_px)


@real
def test_heights_are_scaled_to_1080_rows():
    low = read_video(ANNOTATIONS / "video_0066.xml")  # 1280x720
    assert len(low.onset_heights_px) >= 1


def track(rows: list[tuple[int, str]]) -> str:
    boxes = "".join(
        f'<box frame="{k}" outside="0" ytl="10" ybr="110"><attribute name="cross">{cross}</attribute></box>'
        for k, cross in rows
    )
    meta = "<size>50</size><original_size><width>1280</width><height>720</height></original_size>"
    return f"<annotations><meta><task>{meta}</task></meta><track>{boxes}</track></annotations>"


def test_an_onset_is_a_change_seen_and_no_gap(tmp_path):
    path = tmp_path / "video_0001.xml"
    path.write_text(track([(3, "not-crossing"), (4, "crossing"), (5, "not-crossing"), (8, "crossing")]))
    video = read_video(path)
    assert video.onset_heights_px == (150.0,)
    assert video.positive == {4, 8}


def test_what_is_no_annotation_is_refused_by_name(tmp_path):
    path = tmp_path / "video_0002.xml"
    path.write_text("<annotations/>")
    with pytest.raises(DataError, match="video_0002"):
        read_video(path)
    with pytest.raises(DataError, match="annotations"):
        read_videos(tmp_path / "none")


def test_boxes_follow_from_distance_and_times_from_speed():
    traffic = TrafficConfig(crossing_share=1.0, ego_speed_mps=(10.0, 10.0))
    config = ScenariosConfig(episodes=8, seed=3, traffic=traffic)
    seen = measure(config)
    assert len(seen.onset_ttc_s) >= 4
    np.testing.assert_allclose(seen.onset_ttc_s, seen.onset_distance_m / 10.0)
    pinhole = camera_preset("pie")
    to_camera = seen.onset_distance_m + 0.5 * 4.5 - pinhole.mount_x_m
    tall_m = seen.onset_height_px / pinhole.focal_px * to_camera
    assert tall_m.min() >= 1.0
    assert tall_m.max() <= 1.95
    assert len(seen.positive_share) == len(seen.hit) == 8


def test_the_command_prints_a_table_and_draws_a_figure(tmp_path, capsys):
    assert cli.main(["scenarios", "--episodes", "3", "--out", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert "box at onset" in printed
    assert "56/178/449" in printed
    assert (tmp_path / "scenarios.png").stat().st_size > 1000


def test_settings_that_are_none_are_refused():
    for values in ({"episodes": 0}, {"camera": "piee"}, {"seed": -1}):
        with pytest.raises(ConfigError):
            ScenariosConfig(**values)

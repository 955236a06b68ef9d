import math
from pathlib import Path

import cv2
import numpy as np
import pytest

from eval import cli
from eval.video_events import VideoEventsConfig, make_events
from pedcross_env.errors import ConfigError, DataError
from pedcross_env.sensors.dvs_config import dvs_preset
from pedcross_env.sensors.event_files import read_events
from pedcross_env.sensors.events import png_to_counts
from pedcross_env.sensors.intensity import log_image

VIDEO = Path(__file__).parents[3] / "shared/realdata/video/test_video.mp4"
GREYS = (60, 90, 90, 40)
FPS = 50.0


@pytest.fixture
def brightening(tmp_path):
    """A folder of grey pictures, named so that their order is that of the numbers, not of the letters."""
    folder = tmp_path / "pictures"
    folder.mkdir()
    for name, grey in zip(("f8", "f9", "f10", "f11"), GREYS, strict=True):
        cv2.imwrite(str(folder / f"{name}.png"), np.full((18, 32, 3), grey, np.uint8))
    return folder


def ideal(video, out, **changes):
    return VideoEventsConfig(video=video, out=out, camera="ideal", **{"fps": FPS} | changes)


def test_events_are_those_of_light_that_runs_straight_between_frames(brightening, tmp_path):
    report = make_events(ideal(brightening, tmp_path / "out"))
    config = dvs_preset("ideal")
    levels = [float(log_image(np.full((1, 1), grey, np.uint8), config)[0, 0]) for grey in GREYS]
    # From the first frame's level up by whole thresholds, then down from where that ended.
    rise = math.floor((levels[1] - levels[0]) / 0.2)
    reached = levels[0] + 0.2 * rise
    fall = math.floor((reached - levels[3]) / 0.2)
    assert (report.events, report.on) == (18 * 32 * (rise + fall), 18 * 32 * rise)
    events = read_events(report.path).events
    times = np.unique(events["t"][events["pol"]]) * 1e-9
    expected = [0.2 * (k + 1) / (levels[1] - levels[0]) / FPS for k in range(rise)]
    np.testing.assert_allclose(times, expected, atol=2e-8)
    falling = np.unique(events["t"][~events["pol"]])
    assert falling.min() >= round(2e9 / FPS)  # nothing happens between the second frame and the third


@pytest.mark.parametrize("slow_motion", [1, 3])
def test_frames_hold_every_event_once_and_the_video_shows_each(brightening, tmp_path, slow_motion):
    report = make_events(ideal(brightening, tmp_path / "out", slow_motion=slow_motion))
    pictures = sorted((tmp_path / "out/frames").iterdir())
    assert len(pictures) == 3 * slow_motion
    counts = sum(png_to_counts(cv2.imread(str(path))[..., ::-1]).sum(dtype=int) for path in pictures)
    assert counts == report.events > 0
    video = cv2.VideoCapture(str(report.video))
    assert (video.get(cv2.CAP_PROP_FRAME_COUNT), video.get(cv2.CAP_PROP_FPS)) == (3 * slow_motion, FPS)
    assert not [path for path in (tmp_path / "out").iterdir() if path.name.startswith(".")]


def test_a_shorter_run_leaves_nothing_of_a_longer_one(brightening, tmp_path):
    make_events(ideal(brightening, tmp_path / "out"))
    report = make_events(
        ideal(
            brightening,
            tmp_path / "out",
            start_s=1 / FPS,
            duration_s=1 / FPS,
            frames="carla",
            side_by_side=False,
        )
    )
    assert (report.frames, report.events, report.video) == (2, 0, None)
    assert [path.name for path in (tmp_path / "out/frames").iterdir()] == ["000000.png"]


@pytest.mark.parametrize(("file", "suffix"), [("h5", ".h5"), ("aedat4", ".aedat4")])
def test_other_files_hold_the_same_events_to_the_microsecond(brightening, tmp_path, file, suffix):
    if file == "h5":
        pytest.importorskip("hdf5plugin")
    exact = read_events(make_events(ideal(brightening, tmp_path / "a", frames="none")).path)
    other = read_events(make_events(ideal(brightening, tmp_path / "b", frames="paper", file=file)).path)
    assert other.shape == exact.shape == (18, 32)
    np.testing.assert_array_equal(other.events["t"], exact.events["t"] // 1000 * 1000)
    assert not (tmp_path / "a/frames").exists()


def test_width_shrinks_before_the_camera_looks(brightening, tmp_path):
    assert make_events(ideal(brightening, tmp_path / "out", width_px=16)).shape == (9, 16)


def test_thresholds_and_seeds_act(brightening, tmp_path):
    fine = make_events(ideal(brightening, tmp_path / "a", threshold=0.05)).events
    assert fine > 3 * make_events(ideal(brightening, tmp_path / "b")).events
    runs = [
        make_events(
            VideoEventsConfig(video=brightening, out=tmp_path / name, camera="noisy", fps=FPS, seed=seed)
        ).path.read_bytes()
        for name, seed in (("c", 1), ("d", 1), ("e", 2))
    ]
    assert runs[0] == runs[1] != runs[2]


def test_input_that_is_no_video_is_an_error_with_a_remedy(brightening, tmp_path):
    out = tmp_path / "out"
    with pytest.raises(DataError, match="does not exist"):
        make_events(ideal(tmp_path / "none.mp4", out))
    noise = tmp_path / "noise.mp4"
    noise.write_bytes(bytes(range(256)) * 20)
    with pytest.raises(DataError, match=r"5120 bytes\) is no video that OpenCV reads"):
        make_events(ideal(noise, out))
    with pytest.raises(ConfigError, match="Give --fps"):
        make_events(ideal(brightening, out, fps=None))
    with pytest.raises(DataError, match=r"no frame at 9 s; it ends after 0\.08 s"):
        make_events(ideal(brightening, out, start_s=9.0))
    with pytest.raises(DataError, match="at least two are needed"):
        make_events(ideal(brightening, out, start_s=3 / FPS))
    cv2.imwrite(str(brightening / "f12.png"), np.zeros((9, 9, 3), np.uint8))
    with pytest.raises(DataError, match=r"f12\.png is 9x9, the first picture 32x18"):
        make_events(ideal(brightening, out))
    (brightening / "f12.png").write_bytes(b"no picture")
    with pytest.raises(DataError, match=r"f12\.png \(10 bytes\) is no picture"):
        make_events(ideal(brightening, out))
    empty = tmp_path / "empty"
    empty.mkdir()
    with pytest.raises(DataError, match=r"holds no pictures; read are \.png"):
        make_events(ideal(empty, out))
    assert not (out / "events.npz").exists()


@pytest.mark.skipif(not VIDEO.exists(), reason=f"the real video is not there: {VIDEO}")
def test_a_real_drive_gives_events_in_its_trees_and_none_in_its_sky(tmp_path, capsys):
    arguments = ["events", str(VIDEO), "--out", str(tmp_path), "--width-px", "160", "--duration-s", "0.2"]
    assert cli.main([*arguments, "--no-side-by-side"]) == 0
    assert "6 frames, 160x90, over 0.20 s" in capsys.readouterr().out
    recording = read_events(tmp_path / "events.npz")
    tree, sky = (
        np.mean((recording.events["y"] < 20) & (recording.events["x"] // 40 == column)) for column in (0, 2)
    )
    assert tree > 20 * sky
    assert recording.events["t"].max() < 0.2e9

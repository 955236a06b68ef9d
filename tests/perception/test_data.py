import numpy as np
import pytest
from perception_data import SIDE_PX, block_video, write_dataset, write_video

from pedcross_env.errors import ConfigError, DataError
from perception.data import (
    ClipDataset,
    FrameFolder,
    Video,
    fingerprint,
    read_frame,
    split_by_video,
    window_labels,
    window_starts,
)
from perception.preprocess import Preprocess

RGB = Preprocess(modality="rgb", channels=3, width_px=SIDE_PX, height_px=SIDE_PX, crop_top=0, crop_bottom=1)


def fake_videos(count: int, subset: str = "dataset") -> list[Video]:
    label = np.ones(1, np.uint8)
    return [Video(subset, f"v{i:03d}", "rgb", (), np.zeros(1, np.int64), label) for i in range(count)]


def test_frames_come_in_numeric_order_with_their_labels(tmp_path):
    images, _ = block_video(0, 3, None)
    folder = tmp_path / "dataset_rgb" / "a"
    write_video(folder, images, np.array([0, 1, 0]))
    (folder / "000-0.png").rename(folder / "9-0.png")
    (folder / "001-1.png").rename(folder / "10-1.png")
    (folder / "002-0.png").rename(folder / "100-town-3-0.png")
    (video,) = FrameFolder.open(tmp_path, "dataset", "rgb").videos
    assert video.numbers.tolist() == [9, 10, 100]
    assert video.labels.tolist() == [0, 1, 0]
    assert np.array_equal(read_frame(video.paths[1], "rgb"), images[1])


def test_other_files_and_empty_folders_are_counted_not_read(tmp_path):
    write_dataset(tmp_path, videos=2, frames=2)
    (tmp_path / "dataset_rgb" / "manifest.txt").write_text("x")
    (tmp_path / "dataset_rgb" / "video_00" / "events.npz").write_bytes(b"x")
    (tmp_path / "dataset_rgb" / "nothing").mkdir()
    folder = FrameFolder.open(tmp_path, "dataset", "rgb")
    assert folder.skipped == ("manifest.txt", "video_00/events.npz")
    assert folder.empty == ("nothing",)
    assert [v.name for v in folder.videos] == ["video_00", "video_01"]


def test_missing_folders_name_what_exists(tmp_path):
    write_dataset(tmp_path, videos=1, frames=1)
    with pytest.raises(DataError, match="dataset_rgb"):
        FrameFolder.open(tmp_path, "dataset_weather", "rgb")
    with pytest.raises(DataError, match="not a folder"):
        FrameFolder.open(tmp_path / "elsewhere", "dataset", "rgb")
    with pytest.raises(ConfigError, match="lidar"):
        FrameFolder.open(tmp_path, "dataset", "lidar")


@pytest.mark.parametrize("name", ["000-2.png", "000.png", "x-1.png", "7-.png"])
def test_a_name_without_a_label_is_named(tmp_path, name):
    write_dataset(tmp_path, videos=1, frames=2)
    folder = tmp_path / "dataset_rgb" / "video_00"
    (folder / "001-1.png").rename(folder / name)
    with pytest.raises(DataError, match=name):
        FrameFolder.open(tmp_path, "dataset", "rgb")


def test_one_frame_with_two_labels_is_an_error(tmp_path):
    write_dataset(tmp_path, videos=1, frames=2)
    folder = tmp_path / "dataset_rgb" / "video_00"
    (folder / "1-0.png").write_bytes((folder / "000-0.png").read_bytes())
    with pytest.raises(DataError, match="frame 1 exists twice"):
        FrameFolder.open(tmp_path, "dataset", "rgb")


@pytest.mark.parametrize("suffix", [".png", ".jpg"])
def test_a_truncated_image_is_named_or_left_out_and_reported(tmp_path, suffix):
    write_video(tmp_path / "dataset_rgb" / "v", *block_video(0, 6, 3), suffix)
    video = FrameFolder.open(tmp_path, "dataset", "rgb").videos[0]
    data = video.paths[4].read_bytes()
    video.paths[4].write_bytes(data[: len(data) * 2 // 3])
    with pytest.raises(DataError, match=f"004-1{suffix}"):
        ClipDataset.from_videos([video], RGB, frames=2, overlap=1)
    clips = ClipDataset.from_videos([video], RGB, frames=2, overlap=1, on_error="skip")
    assert len(clips) == 4
    assert clips.labels.tolist() == [0, 0, 1, 1]
    assert f"004-1{suffix}" in clips.errors[0]


def test_windows_of_a_long_video_are_as_many_as_published():
    assert len(window_starts(900, 9, 8)) == 892
    assert len(window_starts(900, 30, 29)) == 871
    assert len(window_starts(900, 9, 0)) == 100
    assert len(window_starts(8, 9, 8)) == 0
    with pytest.raises(ConfigError, match="overlap"):
        window_starts(900, 9, 9)


def test_a_window_is_positive_if_any_of_its_frames_is():
    labels = np.array([0, 0, 0, 1, 0, 0], np.uint8)
    assert window_labels(labels, window_starts(6, 3, 2), 3).tolist() == [0, 1, 1, 1]


def test_the_split_is_the_published_one_whatever_the_order():
    videos = fake_videos(81)
    parts = split_by_video(videos[::-1])
    assert {part: len(members) for part, members in parts.items()} == {
        "train": 57,
        "validation": 11,
        "test": 13,
    }
    assert [int(v.name[1:]) for v in parts["test"]] == [0, 4, 10, 12, 18, 22, 28, 30, 31, 33, 49, 67, 70]


def test_the_same_crossing_in_other_weather_stays_in_one_part():
    parts = split_by_video(fake_videos(20) + fake_videos(20, "dataset_weather"))
    names = [{v.name for v in members} for members in parts.values()]
    assert sum(len(n) for n in names) == 20
    assert sum(len(members) for members in parts.values()) == 40


def test_too_few_videos_to_split_is_an_error():
    with pytest.raises(DataError, match="1 videos"):
        split_by_video(fake_videos(1))


def test_clips_are_the_frames_and_short_videos_are_reported(tmp_path):
    images, labels = block_video(3, 5, 2)
    write_video(tmp_path / "dataset_rgb" / "long", images, labels)
    write_video(tmp_path / "dataset_rgb" / "short", images[:2], labels[:2])
    videos = FrameFolder.open(tmp_path, "dataset", "rgb").videos
    for _ in range(2):  # the second time from the cache
        clips = ClipDataset.from_videos(videos, RGB, frames=3, overlap=1, cache_dir=tmp_path / "cache")
        assert clips.too_short == ("dataset/short",)
        assert clips.labels.tolist() == [1, 1]
        assert np.array_equal(clips.clips(np.array([1, 0])), np.stack([images[2:5], images[0:3]]))
    assert len(list((tmp_path / "cache").iterdir())) == 2


def test_event_images_are_read_as_counts(tmp_path):
    image = np.zeros((16, 16, 3), np.uint8)
    image[2, 3] = (0, 0, 255)  # ON is blue
    image[5, 6] = (255, 0, 0)  # OFF is red
    write_video(tmp_path / "dataset_dvs" / "v", image[None], np.array([0]))
    (video,) = FrameFolder.open(tmp_path, "dataset", "dvs").videos
    counts = read_frame(video.paths[0], "dvs")
    assert counts.shape == (16, 16, 2)
    assert np.argwhere(counts[..., 0]).tolist() == [[2, 3]]
    assert np.argwhere(counts[..., 1]).tolist() == [[5, 6]]


def test_the_fingerprint_follows_names_and_labels(tmp_path):
    write_dataset(tmp_path, videos=1, frames=2)
    first = fingerprint([FrameFolder.open(tmp_path, "dataset", "rgb")])
    assert first == fingerprint([FrameFolder.open(tmp_path, "dataset", "rgb")])
    folder = tmp_path / "dataset_rgb" / "video_00"
    (folder / "001-1.png").rename(folder / "001-0.png")
    assert first != fingerprint([FrameFolder.open(tmp_path, "dataset", "rgb")])

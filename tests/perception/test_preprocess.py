import numpy as np
import pytest

from pedcross_env.errors import ConfigError
from perception.preprocess import IMAGENET_MEAN, IMAGENET_STD, Preprocess


def test_rgb_is_scaled_and_normalised_by_channel():
    image = np.full((64, 112, 3), (0, 128, 255), np.uint8)
    planes = Preprocess.paper("rgb", 32, 16)(image)
    expected = (np.array([0, 128, 255]) / 255 - IMAGENET_MEAN) / np.array(IMAGENET_STD)
    assert planes.shape == (3, 16, 32)
    assert planes.dtype == np.float32
    np.testing.assert_allclose(planes.mean(axis=(1, 2)), expected, rtol=1e-5)


def test_rows_outside_the_band_are_never_seen():
    image = np.zeros((100, 60, 3), np.uint8)
    image[:30], image[80:] = 255, 255
    assert not Preprocess.compact("rgb").shrink(image).any()
    image[30] = 255
    assert Preprocess.compact("rgb").shrink(image).any()


def test_rows_move_the_band_and_its_own_pixels_stay_as_they_are():
    image = np.random.default_rng(0).integers(0, 256, (128, 224, 3), dtype=np.uint8)
    view = Preprocess.compact("rgb", 224, 36, rows=(52 / 128, 88 / 128))
    np.testing.assert_array_equal(view.shrink(image), image[52:88])


def test_area_of_counts_is_their_mean_and_saturates_at_the_clip():
    counts = np.zeros((64, 128, 2), np.uint8)
    counts[0:4, 0:4, 0] = 2
    counts[0, 0, 1] = 200
    view = Preprocess(
        modality="dvs", channels=2, width_px=32, height_px=16, crop_top=0, crop_bottom=1, count_clip=4
    )
    planes = view(counts)
    assert planes[0, 0, 0] == pytest.approx(2 / 4, abs=1 / 255)
    assert planes[1, 0, 0] == pytest.approx(1 / 16, abs=1 / 255)
    assert planes.sum() == pytest.approx(planes[0, 0, 0] + planes[1, 0, 0])


def test_max_keeps_a_single_event_that_nearest_may_lose():
    counts = np.zeros((64, 128, 2), np.uint8)
    counts[33, 65, 0] = 4
    sums = {}
    for resize in ("max", "nearest"):
        view = Preprocess(
            modality="dvs", channels=2, width_px=32, height_px=16, resize=resize, crop_top=0, crop_bottom=1
        )
        sums[resize] = float(view(counts).sum())
    assert sums == {"max": 1.0, "nearest": 0.0}


def test_the_papers_event_view_is_one_grey_channel_in_the_unit_range():
    counts = np.zeros((32, 64, 2), np.uint8)
    counts[4, 5, 0] = counts[8, 9, 1] = 1
    planes = Preprocess.paper("dvs", 64, 32)(counts)
    assert planes.shape == (1, 32, 64)
    assert set(np.argwhere(planes[0] > 0).ravel().tolist()) == {4, 5, 8, 9}
    assert planes.max() <= 1


def test_changes_show_what_moves_and_nothing_else():
    view = Preprocess.compact("rgb", 32, 16, "changes")
    still = np.random.default_rng(0).integers(0, 256, (64, 64, 3), dtype=np.uint8)
    moved = still.copy()
    moved[32:40, 20:24] = 250
    planes = view.normalise(np.stack([view.shrink(image) for image in (still, still, moved, moved)]))
    assert planes.shape == (4, 1, 16, 32)
    assert not planes[[0, 1, 3]].any()
    assert planes[2].any()


def test_a_change_is_one_at_ten_per_cent_of_contrast_and_the_same_in_every_light():
    view = Preprocess.compact("rgb", 8, 8, "changes")
    dim, bright = (
        np.stack([np.full((16, 16, 3), v, np.uint8) for v in pair]) for pair in ((84, 94), (184, 204))
    )
    for pair in (dim, bright):  # both rise by a tenth of (level + 16)
        planes = view.normalise(np.stack([view.shrink(image) for image in pair]))
        np.testing.assert_allclose(planes[1], np.log(1.1) / 0.1, rtol=1e-4)


def test_both_are_the_image_with_its_changes_behind():
    image = np.random.default_rng(0).integers(0, 256, (2, 64, 64, 3), dtype=np.uint8)
    planes = {}
    for kind in ("image", "changes", "both"):
        view = Preprocess.compact("rgb", 32, 16, kind)
        planes[kind] = view.normalise(np.stack([view.shrink(i) for i in image]))
    np.testing.assert_array_equal(
        planes["both"], np.concatenate([planes["image"], planes["changes"]], axis=1)
    )


@pytest.mark.parametrize(
    ("settings", "match"),
    [
        ({"modality": "lidar", "channels": 1}, "lidar"),
        ({"modality": "rgb", "channels": 2}, "channels = 2"),
        ({"modality": "rgb", "channels": 3, "rgb_input": "changes"}, "channels = 3"),
        ({"modality": "rgb", "channels": 3, "rgb_input": "change"}, "changes"),
        ({"modality": "dvs", "channels": 2, "rgb_input": "changes"}, "events are changes already"),
        ({"modality": "rgb", "channels": 3, "crop_top": 0.9}, "crop_top"),
        ({"modality": "rgb", "channels": 3, "resize": "are"}, "area"),
        ({"modality": "rgb", "channels": 3, "mean": (0.5,)}, "mean"),
        ({"modality": "dvs", "channels": 2, "count_clip": 0}, "count_clip"),
        ({"modality": "dvs", "channels": 2, "width_px": 4}, "width_px"),
    ],
)
def test_settings_that_make_no_sense_are_refused(settings, match):
    with pytest.raises(ConfigError, match=match):
        Preprocess(**settings)


def test_images_of_another_kind_are_refused():
    with pytest.raises(ConfigError, match="uint8"):
        Preprocess.compact("rgb").shrink(np.zeros((8, 8, 3)))
    with pytest.raises(ConfigError, match="add 'dvs'"):
        Preprocess.compact("dvs").of_observation({"rgb": np.zeros((8, 8, 3), np.uint8)})

import json

import numpy as np
import pytest
import torch

from pedcross_env.errors import DataError
from perception.checkpoint import CheckpointConfig, list_shipped, load_detector, read_config, save_checkpoint
from perception.preprocess import Preprocess
from perception.registry import create_network
from perception.streaming import NetworkDetector

VIEW = Preprocess.compact("dvs", 32, 32)


@pytest.fixture
def saved(tmp_path):
    torch.manual_seed(0)
    network = create_network("sps_r18t", in_channels=2, frames=3, width=0.125)
    config = CheckpointConfig(
        name="small", model="sps_r18t", modality="dvs", frames=3, width=0.125, preprocess=VIEW, threshold=0.4,
        braking_threshold=0.9,
        metrics={"test_auroc": float("nan"), "test_f1": 0.5}, splits={"test": ["dataset/a"]},
    )  # fmt: skip
    return save_checkpoint(tmp_path / "small", network, config), network


def edit(folder, **changes):
    file = folder / "config.json"
    values = json.loads(file.read_text()) | changes
    file.write_text(json.dumps({k: v for k, v in values.items() if v is not ...}))


def test_a_checkpoint_comes_back_as_it_was(saved):
    folder, network = saved
    detector = load_detector(folder, expect_modality="dvs", expect_frames=3)
    original = NetworkDetector(network, VIEW, name="small", frames=3)
    clips = np.random.default_rng(0).integers(0, 5, (4, 3, 64, 64, 2), dtype=np.uint8)
    assert np.array_equal(detector.predict(clips), original.predict(clips))
    assert (detector.name, detector.threshold, detector.preprocess) == ("small", 0.4, VIEW)
    config = read_config(folder)
    assert config.metrics == {"test_auroc": None, "test_f1": 0.5}
    assert sorted(p.name for p in folder.iterdir()) == ["config.json", "model.safetensors"]


def test_loading_leaves_the_global_generator(saved):
    before = torch.random.get_rng_state()
    load_detector(saved[0])
    assert torch.equal(before, torch.random.get_rng_state())


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"treshold": 0.5}, "Did you mean 'threshold'"),
        ({"model": ...}, "lacks model"),
        ({"model": "sps_r18tt"}, "Did you mean 'sps_r18t'"),
        ({"model": "os:system"}, "unknown network"),
        ({"frames": "3"}, "frames = '3'"),
        ({"frames": 4}, "does not fit"),
        ({"threshold": 1.5}, "threshold"),
        ({"modality": "rgb"}, "preprocessing is for 'dvs'"),
        ({"format_version": 2}, "format_version"),
        ({"width": 0.25}, "does not fit"),
        ({"preprocess": {"modality": "dvs", "channels": 2, "hight_px": 3}}, "height_px"),
        ({"preprocess": []}, "expected an object"),
    ],
)
def test_a_config_that_is_wrong_is_named(saved, changes, match):
    edit(saved[0], **changes)
    with pytest.raises(DataError, match=match):
        load_detector(saved[0])


@pytest.mark.parametrize("name", ["config.json", "model.safetensors"])
def test_missing_and_truncated_files_are_named(saved, name):
    file = saved[0] / name
    data = file.read_bytes()
    file.write_bytes(data[: len(data) // 2])
    with pytest.raises(DataError, match=f"{name}: truncated"):
        load_detector(saved[0])
    file.unlink()
    with pytest.raises(DataError, match=f"{name}: missing"):
        load_detector(saved[0])


def test_weights_that_are_not_finite_are_refused(saved):
    folder, network = saved
    with torch.no_grad():
        network.fc.bias.fill_(float("nan"))
    save_checkpoint(folder, network, read_config(folder))
    with pytest.raises(DataError, match="not finite"):
        load_detector(folder)


def test_expectations_are_checked(saved):
    with pytest.raises(DataError, match="reads 'dvs', but 'rgb'"):
        load_detector(saved[0], expect_modality="rgb")
    with pytest.raises(DataError, match="takes 3 frames, but clips have 9"):
        load_detector(saved[0], expect_frames=9)


def test_an_unknown_name_lists_what_is_shipped(tmp_path):
    with pytest.raises(DataError, match="no checkpoint"):
        load_detector(tmp_path / "nothing")


def test_every_shipped_detector_loads_under_its_name():
    for name in list_shipped():
        assert load_detector(name).name == name

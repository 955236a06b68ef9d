import dataclasses
import json

import numpy as np
import pytest
import torch
from perception_data import SIDE_PX, block_video, write_dataset, write_video
from rich.console import Console

from pedcross_env.errors import ConfigError, DataError, PedcrossError
from perception import training
from perception.checkpoint import load_detector, load_network, read_config
from perception.contract import check_detector
from perception.data import FrameFolder, read_frame
from perception.preprocess import Preprocess
from perception.recipes import RECIPES, augment, learning_rate, make_optimizer
from perception.registry import create_network
from perception.run_state import peek
from perception.scores import best_f1_threshold, score
from perception.training import TrainConfig, train

QUIET = Console(quiet=True)


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    return write_dataset(tmp_path_factory.mktemp("data"), videos=14, frames=10)


def settings(data, out, **changes):
    defaults = {
        "data": data, "out": out, "subsets": ("dataset",),
        "model": "sps_r18t_add", "modality": "rgb", "frames": 3, "width": 0.125,
        "width_px": SIDE_PX, "height_px": SIDE_PX, "view": "paper",
        "train_stride": 1, "epochs": 4, "batch_size": 4,
    }  # fmt: skip
    return TrainConfig(**(defaults | changes))


def weights(folder):
    return load_network(folder)[0].state_dict()


@pytest.fixture(scope="module")
def spiking_run(data, tmp_path_factory):
    out = tmp_path_factory.mktemp("spiking") / "run"
    return out, train(settings(data, out), command="pedcross train", console=QUIET)


def test_one_seed_gives_identical_weights_and_leaves_the_global_generator(data, spiking_run, tmp_path):
    before = torch.random.get_rng_state(), np.random.get_state()[1].copy()  # noqa: NPY002
    train(settings(data, tmp_path), console=QUIET)
    assert torch.equal(before[0], torch.random.get_rng_state())
    assert np.array_equal(before[1], np.random.get_state()[1])  # noqa: NPY002
    first, second = weights(spiking_run[0]), weights(tmp_path)
    assert all(torch.equal(first[name], second[name]) for name in first)


def test_another_seed_gives_other_weights(data, spiking_run, tmp_path):
    train(settings(data, tmp_path, seed=1, epochs=1), console=QUIET)
    assert not torch.equal(weights(spiking_run[0])["conv1.weight"], weights(tmp_path)["conv1.weight"])


def test_a_run_cut_off_after_an_epoch_ends_as_the_uninterrupted_one(data, spiking_run, tmp_path, monkeypatch):
    saved = training.save_run

    def save_and_die(*args, **kwargs):
        saved(*args, **kwargs)
        raise KeyboardInterrupt

    monkeypatch.setattr(training, "save_run", save_and_die)
    with pytest.raises(KeyboardInterrupt):
        train(settings(data, tmp_path), console=QUIET)
    assert peek(tmp_path / "run").epoch == 1
    assert not (tmp_path / "config.json").exists()
    monkeypatch.setattr(training, "save_run", saved)
    result = train(settings(data, tmp_path), console=QUIET)
    assert len(result.history) == 4
    whole, resumed = weights(spiking_run[0]), weights(tmp_path)
    for name in whole:
        torch.testing.assert_close(whole[name], resumed[name])
    assert result.metrics == spiking_run[1].metrics


def test_a_finished_run_is_not_repeated_and_other_settings_are_refused(data, spiking_run):
    out, result = spiking_run
    again = train(settings(data, out), console=QUIET)
    assert again.skipped
    assert again.threshold == result.threshold
    assert again.metrics == json.loads(json.dumps(result.metrics))
    with pytest.raises(ConfigError, match="other settings"):
        train(settings(data, out, seed=5), console=QUIET)


def test_time_ends_a_run_and_more_time_continues_it(data, tmp_path):
    short = settings(data, tmp_path, model="stacked_resnet18", max_minutes=1e-6)
    assert train(short, console=QUIET).stop_reason == "max_minutes"
    assert train(short, console=QUIET).skipped
    result = train(dataclasses.replace(short, max_minutes=None), console=QUIET)
    assert (result.stop_reason, len(result.history)) == ("epochs", 4)


@pytest.mark.parametrize("model", ["stacked_resnet18", "pt_resnet18", "sps_r18t_add"])
def test_networks_learn_what_can_be_learned(tmp_path, model):
    data = write_dataset(tmp_path / "data", videos=40, frames=10)
    result = train(settings(data, tmp_path / "run", model=model, epochs=8, test_stride=1), console=QUIET)
    assert result.metrics["test_auroc"] > 0.9
    assert result.history[-1]["train_loss"] < result.history[0]["train_loss"]


def test_the_checkpoint_reproduces_the_validation_score_by_streaming(data, spiking_run):
    out, result = spiking_run
    detector = load_detector(out, expect_modality="rgb", expect_frames=3)
    videos = {f"{v.subset}/{v.name}": v for v in FrameFolder.open(data, "dataset", "rgb").videos}
    stored = read_config(out)
    labels, p = [], []
    for name in stored.splits["test"]:
        video = videos[name]
        detector.reset()
        images = [read_frame(path, "rgb") for path in video.paths]
        streamed = [detector.update({"rgb": image}) for image in images]
        p += streamed[2::3]
        labels += [video.labels[i - 2 : i + 1].max() for i in range(2, len(images), 3)]
    assert np.ptp(p) > 0.01  # it does see its input
    again = score(np.array(labels), np.array(p), detector.threshold, "test")
    for key, value in again.items():
        assert value == pytest.approx(result.metrics[key], abs=1e-6), key
    assert stored.command == "pedcross train"
    assert set(stored.splits["train"]).isdisjoint(stored.splits["test"])


def test_a_trained_detector_keeps_the_contract(spiking_run):
    assert len(check_detector(load_detector(spiking_run[0]), (SIDE_PX, SIDE_PX))) == 9


def test_bf16_trains_and_stays_close_to_fp32(data, spiking_run, tmp_path):
    result = train(settings(data, tmp_path, model="pt_resnet18", precision="bf16", epochs=1), console=QUIET)
    full = train(settings(data, tmp_path / "full", model="pt_resnet18", epochs=1), console=QUIET)
    assert result.history[0]["train_loss"] == pytest.approx(full.history[0]["train_loss"], rel=0.1)


def test_a_part_with_one_class_is_an_error(tmp_path):
    for i in range(14):
        write_video(tmp_path / "d" / "dataset_rgb" / f"v{i}", *block_video(i, 5, 0 if i == 3 else None))
    with pytest.raises(DataError, match="both classes are needed"):
        train(settings(tmp_path / "d", tmp_path / "out"), console=QUIET)


def test_a_silent_spiking_network_is_an_error(data, tmp_path, monkeypatch):
    monkeypatch.setattr(training, "firing_rates", lambda _network, _clips: {"sn1": 0.0004, "sn2": 0.0})
    with pytest.raises(PedcrossError, match=r"fires 0\.02%"):
        train(settings(data, tmp_path, epochs=1), console=QUIET)


def test_a_silent_layer_is_a_warning(data, tmp_path, monkeypatch):
    monkeypatch.setattr(training, "firing_rates", lambda _network, _clips: {"sn1": 0.1, "layer4.sn2": 0.0})
    with pytest.warns(UserWarning, match=r"layer4\.sn2"):
        train(settings(data, tmp_path, epochs=1), console=QUIET)


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"model": "pt_resnet"}, "pt_resnet18"),
        ({"recipe": "papr"}, "paper"),
        ({"train_stride": 4}, "train_stride"),
        ({"epochs": 0}, "epochs"),
        ({"rgb_input": "changes"}, "view 'compact'"),
        ({"rows": (0.4, 0.7)}, "sees the whole image"),
        ({"subsets": "dataset"}, "subsets"),
        ({"max_minutes": 0}, "max_minutes"),
    ],
)
def test_wrong_settings_are_refused(tmp_path, changes, match):
    with pytest.raises(ConfigError, match=match):
        settings(tmp_path, tmp_path, **changes)


def test_rows_reach_the_network_and_are_part_of_the_runs_identity(tmp_path):
    banded, plain = (settings(tmp_path, tmp_path, view="compact", rows=rows) for rows in ((0.4, 0.7), None))
    assert (banded.preprocess().crop_top, banded.preprocess().crop_bottom) == (0.4, 0.7)
    assert plain.preprocess() == Preprocess.compact("rgb", SIDE_PX, SIDE_PX)
    assert banded.settings() != plain.settings()


def test_one_cycle_rises_then_falls_and_the_papers_rate_is_constant():
    rates = [learning_rate(RECIPES["compact"], step, 100) for step in range(100)]
    assert rates[0] == pytest.approx(2e-3 / 25)
    assert max(rates) == rates[30] == pytest.approx(2e-3)
    assert all(np.diff(rates[:31]) > 0)
    assert all(np.diff(rates[30:]) < 0)
    assert {learning_rate(RECIPES["paper"], step, 100) for step in range(100)} == {1e-3}


def test_the_spiking_recipe_differs_in_its_rate_alone():
    spiking, compact = RECIPES["compact-spiking"], RECIPES["compact"]
    assert spiking.rate == 2 * compact.rate
    assert dataclasses.replace(spiking, rate=compact.rate) == compact


def test_only_the_papers_recipe_decays_tau_and_the_temporal_scale():
    network = create_network("sps_r18t", in_channels=1, frames=3, width=0.125)
    for name, decayed in (("paper", True), ("compact", False)):
        groups = make_optimizer(network, RECIPES[name]).param_groups
        decay = {id(p): group["weight_decay"] for group in groups for p in group["params"]}
        assert len(decay) == len(list(network.parameters()))
        assert (decay[id(network.sn1.w)] > 0) == (decay[id(network.bn1.scale)] > 0) == decayed
        assert decay[id(network.conv1.weight)] > 0


def test_augmentation_keeps_time_and_moves_whole_clips():
    rng = np.random.default_rng(0)
    frame = rng.integers(1, 255, (24, 24, 2), dtype=np.uint8)
    clips = np.stack(
        [np.stack([np.clip(frame.astype(int) + t, 0, 255).astype(np.uint8) for t in range(3)])] * 40
    )
    before = clips.copy()
    out = augment(clips, np.random.default_rng(1))
    assert np.array_equal(clips, before)
    assert np.array_equal(out, augment(clips, np.random.default_rng(1)))
    kinds = {o.tobytes() for o in out}
    assert len(kinds) > 5
    for clip in out:  # the same move, flip or hole in every frame: they still differ by time alone
        assert set(np.unique(clip[1].astype(int) - clip[0])) <= {0, 1}
        assert (clip[2].sum() >= clip[0].sum()).all()


def test_scores_match_their_definitions():
    labels, p = np.array([0, 0, 1, 1, 0]), np.array([0.1, 0.4, 0.35, 0.8, 0.2])
    threshold = best_f1_threshold(labels, p)
    f1 = {t: 2 * (labels & (p >= t)).sum() / (labels.sum() + (p >= t).sum()) for t in p}
    assert f1[threshold] == max(f1.values())
    values = score(labels, p, threshold, "x")
    pairs = [(a > b) for a in p[labels == 1] for b in p[labels == 0]]
    assert values["x_auroc"] == pytest.approx(np.mean(pairs))
    assert values["x_f1"] == pytest.approx(max(f1.values()))
    assert np.isnan(score(np.zeros(3), np.full(3, 0.5), 0.5, "x")["x_auroc"])

import numpy as np
import pytest
import torch

from pedcross_env.errors import ConfigError
from perception.contract import DetectorContractError, check_detector
from perception.detector import Detector
from perception.models.spiking import fresh_state
from perception.preprocess import Preprocess
from perception.registry import NETWORKS, create_network
from perception.streaming import NetworkDetector, clip_tensor

FRAMES = 4


def detector(name: str = "sps_r18t_add", modality: str = "dvs", rgb_input: str = "image") -> NetworkDetector:
    view = Preprocess.compact(modality, 32, 32, rgb_input)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)
        network = create_network(name, in_channels=view.channels, frames=FRAMES, width=0.125)
    for module in network.modules():
        if isinstance(module, torch.nn.modules.batchnorm._BatchNorm):
            module.momentum = 1.0  # real statistics at once: without them a spiking network is silent
            torch.nn.init.constant_(module.weight, 2.0)
    small = np.stack([view.shrink(image) for image in video(6 * FRAMES, modality)])
    shown = clip_tensor(small.reshape(6, FRAMES, *small.shape[1:]), view)
    with torch.no_grad(), fresh_state(network):
        network.train()(shown)
    return NetworkDetector(network, view, name=name, frames=FRAMES)


def video(count: int, modality: str = "dvs") -> np.ndarray:
    high, channels = (5, 2) if modality == "dvs" else (256, 3)
    return np.random.default_rng(2).integers(0, high, (count, 64, 64, channels), dtype=np.uint8)


@pytest.mark.parametrize("name", list(NETWORKS))
def test_streaming_equals_windows_on_the_same_frames(name):
    subject, images = detector(name), video(9)
    streamed = [subject.update({"dvs": image}) for image in images]
    windows = np.stack([images[i : i + FRAMES] for i in range(len(images) - FRAMES + 1)])
    predicted = subject.predict(windows)
    np.testing.assert_allclose(streamed[FRAMES - 1 :], predicted, atol=1e-5)
    assert np.ptp(predicted) > 1e-4  # not equal because nothing fires


@pytest.mark.parametrize("rgb_input", ["changes", "both"])
@pytest.mark.parametrize("name", ["pt_resnet18", "stacked_resnet18", "sps_r18t"])
def test_detectors_of_changes_keep_the_contract(name, rgb_input):
    assert len(check_detector(detector(name, "rgb", rgb_input), (48, 64))) == 9


@pytest.mark.parametrize("name", ["pt_resnet18", "sps_r18t_add"])
def test_before_the_window_is_full_the_first_frame_stands_in_front(name):
    subject, images = detector(name), video(2)
    streamed = [subject.update({"dvs": image}) for image in images]
    padded = np.stack([images[[0, 0, 0, 0]], images[[0, 0, 0, 1]]])
    np.testing.assert_allclose(streamed, subject.predict(padded), atol=1e-5)


@pytest.mark.parametrize("modality", ["rgb", "dvs"])
@pytest.mark.parametrize("name", list(NETWORKS))
def test_every_network_keeps_the_detector_contract(name, modality):
    subject = detector(name, modality)
    assert isinstance(subject, Detector)
    assert len(check_detector(subject, (48, 64))) == 9


def test_clips_of_another_length_are_refused():
    with pytest.raises(ConfigError, match="cut windows of 4 frames"):
        detector().predict(video(5)[None])


class _Leaky:
    """Forgets to reset its state."""

    name, modality, frames = "leaky", "dvs", 2

    def __init__(self):
        self.seen = 0.0

    def reset(self):
        pass

    def update(self, observation):
        self.seen = 0.5 * self.seen + 0.01 * float(observation["dvs"].mean())
        return self.seen

    def predict(self, clips):
        return np.array([self.update({"dvs": clip}) for clip in clips])


def test_the_contract_finds_state_that_leaks():
    with pytest.raises(DetectorContractError, match="reset"):
        check_detector(_Leaky(), (16, 16))


def test_the_contract_finds_predictions_that_leak():
    class ResetsButLeaks(_Leaky):
        def reset(self):
            self.seen = 0.0

    with pytest.raises(DetectorContractError, match="leak"):
        check_detector(ResetsButLeaks(), (16, 16))


def test_the_contract_finds_values_that_are_no_probabilities():
    class Logits(_Leaky):
        def update(self, observation):
            return 3.0

    with pytest.raises(DetectorContractError, match="updates"):
        check_detector(Logits(), (16, 16))
    with pytest.raises(DetectorContractError, match="lacks name"):
        check_detector(object(), (16, 16))

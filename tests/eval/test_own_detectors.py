"""A detector of a user's own, named by module:factory."""

import pytest

from eval.detectors import load_detector, resolve_detectors
from pedcross_env.errors import ConfigError
from perception.contract import check_detector

SOURCE = """
import numpy as np

class MoreEventsThanUsual:
    name, modality, frames, braking_threshold = "more-events", "dvs", 1, 0.8

    def reset(self):
        pass

    def update(self, observation):
        return float(self.predict(observation["dvs"][None, None])[0])

    def predict(self, clips):
        return 1 / (1 + np.exp(-(clips[..., 0].mean(axis=(1, 2, 3)) - 0.2) * 20))

def factory():
    return MoreEventsThanUsual()

def unfinished():
    return object()
"""


@pytest.fixture
def mine(tmp_path, monkeypatch):
    name = f"mine_{tmp_path.name}".replace("-", "_")
    (tmp_path / f"{name}.py").write_text(SOURCE)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    return name


def test_a_factory_is_described_and_loaded(mine):
    (spec,) = resolve_detectors([f"{mine}:factory"])
    assert (spec.name, spec.modality, spec.threshold, spec.braking_threshold) == (
        "more-events",
        "dvs",
        0.5,
        0.8,
    )
    assert "streaming_equals_windows" in check_detector(load_detector(spec.path), (16, 24))


def test_an_edited_detector_has_another_fingerprint(mine, tmp_path):
    (before,) = resolve_detectors([f"{mine}:factory"])
    (tmp_path / f"{mine}.py").write_text(SOURCE.replace("0.2", "0.3"))
    (after,) = resolve_detectors([f"{mine}:factory"])
    assert before.fingerprint != after.fingerprint


@pytest.mark.parametrize(
    ("what", "hint"),
    [(":no_such", "no_such"), (":unfinished", "modality"), ("_not_there:factory", "No module")],
)
def test_what_cannot_be_loaded_is_named(mine, what, hint):
    with pytest.raises(ConfigError, match=hint):
        resolve_detectors([mine + what])

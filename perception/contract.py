"""Named checks that any detector can be run through, also one of your own.

from perception.contract import check_detector
check_detector(my_detector, image_shape=(256, 450))
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pedcross_env.contracts import MODALITIES
from pedcross_env.errors import PedcrossError
from perception.detector import Detector

__all__ = ["CHECKS", "DetectorContractError", "check_detector"]


class DetectorContractError(PedcrossError):
    """A detector that breaks the protocol; the message names the check and the remedy."""


Clips = np.ndarray
_CHANNELS = {"rgb": 3, "dvs": 2}


def _fail(detector: Detector, check: str, text: str) -> DetectorContractError:
    return DetectorContractError(f"{type(detector).__name__}: {check}: {text}")


def _observation(detector: Detector, image: np.ndarray) -> dict[str, np.ndarray]:
    return {detector.modality: image, "ego": np.zeros(3, np.float32)}


def _stream(detector: Detector, clip: np.ndarray) -> list[float]:
    detector.reset()
    return [detector.update(_observation(detector, image)) for image in clip]


def _updates_are_probabilities(detector: Detector, clips: Clips) -> None:
    for value in _stream(detector, clips[0]):
        if not isinstance(value, float) or not 0 <= value <= 1:
            raise _fail(detector, "updates", f"update() returned {value!r}; it must be a float in [0, 1].")


def _reset_forgets(detector: Detector, clips: Clips) -> None:
    first = _stream(detector, clips[0])
    _stream(detector, clips[1])
    if _stream(detector, clips[0]) != first:
        raise _fail(
            detector, "reset", "the same frames gave other values after reset(); clear all state there."
        )


def _predictions_are_probabilities(detector: Detector, clips: Clips) -> None:
    p = detector.predict(clips)
    if not isinstance(p, np.ndarray) or p.shape != (len(clips),) or p.dtype != np.float64:
        raise _fail(detector, "predict", f"returned {p!r}; it must be a ({len(clips)},) float64 array.")
    if not np.all((p >= 0) & (p <= 1)):
        raise _fail(detector, "predict", f"returned {p}; all must be in [0, 1].")


def _no_clips_give_no_predictions(detector: Detector, clips: Clips) -> None:
    p = detector.predict(clips[:0])
    if p.shape != (0,):
        raise _fail(detector, "empty predict", f"no clips gave shape {p.shape}; it must be (0,).")


def _clips_do_not_leak(detector: Detector, clips: Clips) -> None:
    together = detector.predict(clips)
    alone = np.concatenate([detector.predict(clips[i : i + 1]) for i in reversed(range(len(clips)))])[::-1]
    if not np.allclose(together, alone, atol=1e-4):
        raise _fail(
            detector, "leak", f"clips give {alone} one by one but {together} in a batch; reset between clips."
        )


def _predict_leaves_the_stream(detector: Detector, clips: Clips) -> None:
    expected = _stream(detector, clips[0])[-1]
    _stream(detector, clips[0][:-1])
    detector.predict(clips[1:])
    if abs(detector.update(_observation(detector, clips[0][-1])) - expected) > 1e-6:
        raise _fail(detector, "predict and update", "predict() changed the streaming state; keep them apart.")


def _inputs_are_untouched(detector: Detector, clips: Clips) -> None:
    copy = clips.copy()
    detector.predict(clips)
    _stream(detector, clips[0])
    if not np.array_equal(copy, clips):
        raise _fail(detector, "inputs", "the images given were changed in place; work on a copy.")


def _lacking_modality_is_an_error(detector: Detector, clips: Clips) -> None:
    detector.reset()
    try:
        detector.update({"ego": np.zeros(3, np.float32)})
    except (PedcrossError, KeyError):
        return
    raise _fail(detector, "observation", f"update() without {detector.modality!r} returned; it must raise.")


def _streaming_equals_windows(detector: Detector, clips: Clips) -> None:
    streamed = [_stream(detector, clip)[-1] for clip in clips]
    predicted = detector.predict(clips)
    if not np.allclose(streamed, predicted, atol=1e-4):
        raise _fail(detector, "windows", f"after T frames update() gives {streamed}, predict() {predicted}.")


CHECKS: tuple[Callable[[Detector, Clips], None], ...] = (
    _updates_are_probabilities, _reset_forgets, _predictions_are_probabilities, _no_clips_give_no_predictions,
    _clips_do_not_leak, _predict_leaves_the_stream, _inputs_are_untouched, _lacking_modality_is_an_error,
)  # fmt: skip


def check_detector(
    detector: Detector, image_shape: tuple[int, int], *, seed: int = 0, windowed: bool = True
) -> tuple[str, ...]:
    """Run a detector through all checks on random images.

    Args:
        detector: Any object with the protocol's attributes and methods.
        image_shape: (H, W) of the images it is shown.
        seed: Of the images.
        windowed: Also check that streaming T frames equals ``predict`` on them; False for
            detectors that keep state beyond T frames by design.

    Returns:
        The names of the checks passed.

    Raises:
        DetectorContractError: At the first check that fails.
    """
    if not isinstance(detector, Detector):
        needed = ("name", "modality", "frames", "reset", "update", "predict")
        lacking = [name for name in needed if not hasattr(detector, name)]
        raise DetectorContractError(f"{type(detector).__name__}: protocol: lacks {', '.join(lacking)}.")
    if not isinstance(detector.name, str) or detector.modality not in MODALITIES or detector.frames < 1:
        raise _fail(detector, "attributes", "name must be a str, modality 'rgb' or 'dvs', frames 1 or more.")
    rng = np.random.default_rng(seed)
    shape = (3, detector.frames, *image_shape, _CHANNELS[detector.modality])
    clips = rng.integers(0, 256 if detector.modality == "rgb" else 5, shape, dtype=np.uint8)
    checks = (*CHECKS, _streaming_equals_windows) if windowed else CHECKS
    for check in checks:
        check(detector, clips)
    detector.reset()
    return tuple(check.__name__.strip("_") for check in checks)

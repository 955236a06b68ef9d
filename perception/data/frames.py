"""The paper's layout: ``<root>/<subset>_<modality>/<video>/<frame>-<label>.<jpg|png>``.

Order and labels are read from the names as the published code does (szmazurek/snn_dvs): by the integer
before the first "-", label after the last "-"; but nothing depends on the order of the file system.
"""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from pedcross_env.contracts import MODALITIES, Modality
from pedcross_env.errors import DataError, unknown_name
from pedcross_env.sensors.events import png_to_counts

__all__ = ["FrameFolder", "Video", "fingerprint", "read_frame"]

_IMAGE_SUFFIXES = {".jpg", ".jpeg", ".png"}
_NAME = re.compile(r"(\d+)-(?:.*-)?([01])")


@dataclass(frozen=True, slots=True)
class Video:
    """One video folder.

    Attributes:
        subset: Name without the modality, e.g. "dataset_weather".
        name: Folder name.
        modality: What the images hold.
        paths: N image files in order of time.
        numbers: (N,) int64 frame numbers, increasing.
        labels: (N,) uint8, 1 while a pedestrian crosses.
    """

    subset: str
    name: str
    modality: Modality
    paths: tuple[Path, ...]
    numbers: np.ndarray
    labels: np.ndarray


def _read_names(folder: Path) -> tuple[list[tuple[int, int, Path]], list[str]]:
    """Return (number, label, path) of every image in order, and the names that are no images."""
    frames: dict[int, tuple[int, int, Path]] = {}
    skipped: list[str] = []
    for path in sorted(folder.iterdir()):
        if path.suffix.lower() not in _IMAGE_SUFFIXES or path.name.startswith("."):
            skipped.append(f"{folder.name}/{path.name}")
            continue
        match = _NAME.fullmatch(path.stem)
        if match is None:
            raise DataError(
                f"{path}: the name must be <frame>-<label> with label 0 or 1, e.g. 00012-1{path.suffix}; "
                "rename or remove the file."
            )
        number, label = int(match[1]), int(match[2])
        if number in frames:
            raise DataError(
                f"{path}: frame {number} exists twice, also as {frames[number][2].name}; keep one."
            )
        frames[number] = (number, label, path)
    return [frames[number] for number in sorted(frames)], skipped


@dataclass(frozen=True, slots=True)
class FrameFolder:
    """All videos of one subset and modality.

    Attributes:
        root, subset, modality: Where it was opened.
        videos: Sorted by name, each with at least one frame.
        skipped: Names of files that are no images (manifests, event files, ...).
        empty: Names of folders without an image.
    """

    root: Path
    subset: str
    modality: Modality
    videos: tuple[Video, ...]
    skipped: tuple[str, ...]
    empty: tuple[str, ...]

    @classmethod
    def open(cls, root: str | Path, subset: str, modality: Modality) -> FrameFolder:
        """Read the names of all frames; no image is opened.

        Raises:
            ConfigError: For an unknown modality.
            DataError: Where the folder is missing (names what exists) or holds no frame, or where
                a name has no label.
        """
        if modality not in MODALITIES:
            raise unknown_name("modality", modality, MODALITIES)
        root = Path(root)
        if not root.is_dir():
            raise DataError(
                f"data root {str(root)!r} is not a folder; record a data set first or mend the path."
            )
        folder = root / f"{subset}_{modality}"
        if not folder.is_dir():
            found = sorted(p.name for p in root.iterdir() if p.is_dir() and p.name.endswith(("_rgb", "_dvs")))
            raise DataError(
                f"{str(root)!r} has no {folder.name!r} (subset {subset!r}, modality {modality!r}); "
                f"it has: {', '.join(found) or 'no *_rgb or *_dvs folder'}."
            )
        videos, skipped, empty = [], [], []
        for entry in sorted(folder.iterdir()):
            if not entry.is_dir():
                skipped.append(entry.name)
                continue
            frames, others = _read_names(entry)
            skipped += others
            if not frames:
                empty.append(entry.name)
                continue
            numbers, labels, paths = zip(*frames, strict=True)
            videos.append(
                Video(
                    subset,
                    entry.name,
                    modality,
                    paths,
                    np.array(numbers, np.int64),
                    np.array(labels, np.uint8),
                )
            )
        if not videos:
            raise DataError(f"{str(folder)!r} holds no frame in {len(empty)} video folders.")
        return cls(root, subset, modality, tuple(videos), tuple(skipped), tuple(empty))


def _check_complete(data: bytes, path: Path) -> None:
    """Refuse a file cut short: OpenCV fills what is missing with grey and says nothing."""
    if path.suffix.lower() == ".png":
        complete = data.startswith(b"\x89PNG\r\n\x1a\n") and b"IEND" in data[-12:]
    else:
        complete = data.startswith(b"\xff\xd8") and data.rstrip(b"\x00").endswith(b"\xff\xd9")
    if not complete:
        raise DataError(
            f"{path}: truncated or not a {path.suffix[1:]} file ({len(data)} bytes); restore or remove it."
        )


def read_frame(path: Path, modality: Modality) -> np.ndarray:
    """Read one image as the environment would observe it.

    Returns:
        rgb: (H, W, 3) uint8; dvs: (H, W, 2) uint8 counts, ON and OFF.

    Raises:
        DataError: Where the file is missing, truncated or no image; names the file.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise DataError(f"{path}: cannot be read ({error.strerror}).") from error
    _check_complete(data, path)
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    if image is None:
        raise DataError(f"{path}: damaged image; restore or remove it.")
    image = np.ascontiguousarray(image[..., ::-1])
    return image if modality == "rgb" else png_to_counts(image)


def fingerprint(folders: list[FrameFolder]) -> str:
    """Return a hash of the sorted names and labels of all frames and of the manifests' versions."""
    digest = hashlib.sha256()
    for folder in sorted(folders, key=lambda f: (f.subset, f.modality)):
        for video in folder.videos:
            for path in video.paths:
                digest.update(f"{folder.subset}_{folder.modality}/{video.name}/{path.name}\n".encode())
    for root in sorted({folder.root for folder in folders}):
        for manifest in sorted(root.glob("*.parquet")):
            digest.update(f"{manifest.name} {_manifest_versions(manifest)}\n".encode())
    return digest.hexdigest()[:32]


def _manifest_versions(manifest: Path) -> str:
    import pyarrow.parquet

    try:
        metadata = pyarrow.parquet.read_schema(manifest).metadata or {}
    except (OSError, pyarrow.ArrowException) as error:
        raise DataError(f"{manifest}: damaged manifest ({error}).") from error
    return str(sorted(metadata.items()))

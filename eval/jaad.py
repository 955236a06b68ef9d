"""What JAAD's annotations say of crossings: figures of the whole set, and of files at hand.

JAAD (Rasouli et al., 2017; annotations under MIT) has one XML file per dashcam video: tracks of pedestrians with a box
and behaviour per frame. A frame is positive where a box has ``cross="crossing"``.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path

from pedcross_env.errors import DataError

__all__ = [
    "CROSSING_S", "LOOKING", "ONSET_HEIGHT_PX", "POSITIVE_VIDEOS", "STANDING", "Video", "read_video", "read_videos",
]  # fmt: skip


POSITIVE_VIDEOS = 269 / 346
ONSET_HEIGHT_PX = (56.0, 178.0, 449.0)
"""Box where a crossing begins, of 1080 rows: 5th percentile, median, 95th."""
CROSSING_S = 4.9
"""Median of a full crossing."""
LOOKING, STANDING = 0.589, 0.342
"""Shares in the last second before a crossing."""


@dataclass(frozen=True, slots=True)
class Video:
    """Crossings in one video.

    Attributes:
        name: E.g. "video_0007".
        frames: Their number.
        positive: Frames in which somebody crosses.
        onset_heights_px: Box heights where somebody begins to cross in view, scaled to 1080 rows.
    """

    name: str
    frames: int
    positive: frozenset[int]
    onset_heights_px: tuple[float, ...]


def read_video(path: Path) -> Video:
    """Read ``annotations/video_NNNN.xml``.

    Tracks may have gaps: who is seen again crossing after one has not begun to cross there.

    Raises:
        DataError: Where the file is no such annotation.
    """
    try:
        root = ElementTree.parse(path).getroot()
        frames = int(root.findtext("./meta/task/size") or "")
        rows = float(root.findtext("./meta/task/original_size/height") or "")
    except (ElementTree.ParseError, ValueError, OSError) as error:
        raise DataError(f"{path}: not an annotation of JAAD ({error}).") from error
    positive: set[int] = set()
    heights: list[float] = []
    for track in root.iter("track"):
        before: tuple[int, bool] | None = None
        for box in track.iter("box"):
            if box.get("outside") == "1":
                continue
            frame = int(box.get("frame", "-1"))
            said = {item.get("name"): item.text for item in box.iter("attribute")}
            crossing = said.get("cross") == "crossing"
            if crossing:
                positive.add(frame)
                if before is not None and before == (frame - 1, False):
                    height = float(box.get("ybr", "nan")) - float(box.get("ytl", "nan"))
                    heights.append(height * 1080.0 / rows)
            before = frame, crossing
    return Video(path.stem, frames, frozenset(positive), tuple(heights))


def read_videos(folder: Path) -> list[Video]:
    """Read all annotations in a folder, by name.

    Raises:
        DataError: Where there are none.
    """
    paths = sorted(folder.glob("video_*.xml"))
    if not paths:
        raise DataError(f"{folder}: no video_*.xml here; give JAAD's 'annotations' folder.")
    return [read_video(path) for path in paths]

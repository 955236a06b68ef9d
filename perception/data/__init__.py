"""Frames on disk to labelled clips in memory."""

from perception.data.clips import ClipDataset, load_video
from perception.data.frames import FrameFolder, Video, fingerprint, read_frame
from perception.data.windows import split_by_video, window_labels, window_starts

__all__ = [
    "ClipDataset", "FrameFolder", "Video", "fingerprint", "load_video", "read_frame", "split_by_video",
    "window_labels", "window_starts",
]  # fmt: skip

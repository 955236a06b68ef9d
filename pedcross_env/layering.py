"""A step's pictures put together from layers of the scene, each rendered at some instants and straight in between."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple, Protocol

from pedcross_env.camera import Layer, Picture, Seen, picture_of

__all__ = ["Cadence", "Pictures", "renders_of"]


class Cadence(NamedTuple):
    """A layer, and how many instants lie between two of its renders (1: it is rendered at each)."""

    layer: Layer
    stride: int


class Render(Protocol):
    """Gives layers at an instant of a step, counted from 1."""

    def __call__(self, instant: int, layers: list[Layer], *, passing: bool) -> list[Seen]:
        """Render; with ``passing``, what it gives need only last to the next call."""


class Pictures:
    """A step's pictures put together from layers, each rendered at some of its instants and straight in between.

    What is nearest is rendered when its picture is due, after what is behind it, and looked at while it is in the
    processor's cache.

    Args:
        parts: The layers, the nearest first.
        first: The layers behind the nearest one at the step's start.
        instants: Number of instants that follow; all layers are rendered at the last one.
        render: Renders.

    Attributes:
        far: The layers behind the nearest one as they were rendered last.
    """

    def __init__(
        self, parts: Sequence[Cadence], first: Sequence[Seen], instants: int, render: Render
    ) -> None:
        self._parts, self._instants, self._render = parts, instants, render
        self.far = list(first)

    def __iter__(self) -> Iterator[Picture]:
        """Give the picture at each instant, which lasts until the next one is asked for."""
        near, *behind = self._parts
        spans = [(_Look(0, seen), _Look(0, seen)) for seen in self.far]
        kept: dict[int, Seen] = {}
        for instant in range(1, self._instants + 1):
            due: dict[int, list[int]] = {}
            for k, (_, end) in enumerate(spans):
                if end.instant < instant:
                    due.setdefault(min(self._instants, end.instant + behind[k].stride), []).append(k)
            for at, places in due.items():
                layers = [behind[k].layer for k in places]
                if at in kept:
                    found = self._render(at, layers, passing=False)
                else:
                    kept[at], *found = self._render(at, [near.layer, *layers], passing=False)
                for k, seen in zip(places, found, strict=True):
                    spans[k] = spans[k][1], _Look(at, seen)
                    self.far[k] = seen
            seen = (
                kept.pop(instant) if instant in kept else self._render(instant, [near.layer], passing=True)[0]
            )
            yield picture_of([(seen, seen, 0.0), *(_at(instant, *span) for span in spans)])


class _Look(NamedTuple):
    """A render of a layer at an instant."""

    instant: int
    seen: Seen


def _at(instant: int, start: _Look, end: _Look) -> tuple[Seen, Seen, float]:
    """Two renders and where between them an instant lies."""
    if instant == end.instant:
        return end.seen, end.seen, 0.0
    return start.seen, end.seen, (instant - start.instant) / (end.instant - start.instant)


def renders_of(parts: Sequence[Cadence], instants: int) -> int:
    """Number of renders that ``Pictures`` asks for."""
    return sum(-(-instants // part.stride) for part in parts)

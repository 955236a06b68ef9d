"""The event camera in the world: when it looks, what it senses and what its events are put down to."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from pedcross_env.camera import Layer, Picture, Seen, whole_picture
from pedcross_env.config import EnvConfig
from pedcross_env.contracts import EVENT_DTYPE, Frame, Snapshot
from pedcross_env.flow import image_flow_px
from pedcross_env.layering import Cadence, Pictures, renders_of
from pedcross_env.parting import Parting
from pedcross_env.sensors import causes, dvs
from pedcross_env.sensors.dvs_pictures import count_pictures, log_picture
from pedcross_env.view import View

__all__ = ["EventVision", "Plan", "Sensed"]

LIGHT_STEP = 0.3  # change of the logarithm of the sky's light by lightning between two renders
LIGHT_GRID_S = 0.25e-3


class Plan(NamedTuple):
    """When to render for the events of a policy step.

    Attributes:
        times_s: Ends of the intervals, the last one the step's; the first one begins with the step.
        flow_px: Bound on the image's motion between two renders.
        streak: How many of its diameters a 2 mm drop (or a 5 mm flake) falls between two renders, at most.
    """

    times_s: list[float]
    flow_px: float
    streak: float


@dataclass(frozen=True, slots=True)
class Sensed:
    """What the event camera delivered for one policy step.

    Attributes:
        counts: (H, W, 2) uint8 events ON, OFF, saturating.
        events: (N,) EVENT_DTYPE, None unless asked for.
        causes: (N,) int32 of the events, see ``sensors.causes``; None unless asked for.
        instants: How often luminance is rendered.
        renders: Number of renders: the same, or more where the scene is parted into layers, each a part of it.
        flow_px: Bound on the image's motion between two renders, of any part.
        streak: Bound on a drop's fall between two of them, in its diameters; 0 where nothing falls.
    """

    counts: np.ndarray
    events: np.ndarray | None
    causes: np.ndarray | None
    instants: int
    renders: int
    flow_px: float
    streak: float


@dataclass(frozen=True, slots=True)
class _Trace:
    """One render as labels need it: ids and depth of surfaces, ln of luminance without and with precipitation."""

    frame: Frame
    bare: np.ndarray
    seen: np.ndarray
    flash_lx: float


class EventVision:
    """The event camera of an episode; begins at time 0 with no events, or where another one left off.

    Args:
        config: The environment's.
        view: What it looks at.
        seed: Of the sensor.
        memory: Of another one, which it continues; None: it begins.
    """

    def __init__(self, config: EnvConfig, view: View, seed: int, memory: Any = None) -> None:
        self._config, self._view = config, view
        self._far: dict[Any, Seen] = {}  # as the last step left them: what the next one would render again
        around = view.renderer.surroundings
        if memory is not None:
            self._state, self._trace, planes = memory
            self._parting = Parting(config.camera, around, planes)
            return
        self._parting = Parting(config.camera, around)
        first = view.world.snapshot(0.0)
        picture, bare = self._picture(first, 1.0 / config.world.policy_hz, None)
        log_frame = self._log(picture)
        self._state = dvs.initial_state(log_frame, 0, config.dvs, seed)
        self._trace = self._traced(first, bare, log_frame) if config.label_events else None

    @property
    def memory(self) -> Any:
        """All that the next look depends on, besides what is seen."""
        return self._state, self._trace, self._parting.planes

    def nothing(self) -> Sensed:
        """What there is before the first step."""
        config = self._config
        counts = np.zeros((config.camera.height_px, config.camera.width_px, 2), np.uint8)
        events = np.empty(0, EVENT_DTYPE) if config.return_events else None
        return Sensed(counts, events, np.empty(0, np.int32) if config.label_events else None, 0, 0, 0.0, 0.0)

    def look(self, before: Snapshot, after: Snapshot, depth: np.ndarray | None) -> Sensed:
        """Sense the policy step between two snapshots.

        Args:
            before: Its start.
            after: Its end.
            depth: (H, W) float32 of a render shortly before, which hides the rain behind things; None: nothing does.
        """
        config, plan = self._config, self.plan(before, after)
        counts = self.nothing().counts
        moments = [*self._view.world.snapshots(plan.times_s[:-1]), after]
        parts = self._parted(before, after, len(moments), plan.flow_px)
        renders = renders_of(parts, len(moments)) if parts else len(moments)
        reached = len(moments), renders, plan.flow_px, plan.streak
        pictures = (
            self._put_together(parts, before, moments) if parts else self._whole(before, moments, depth)
        )
        if not config.return_events:
            timed = ((picture, _ns(at)) for at, (picture, _) in zip(moments, pictures, strict=True))
            self._state = count_pictures(self._state, timed, config.dvs, counts)
            return Sensed(counts, None, None, *reached)
        sensed: list[np.ndarray] = []
        labels: list[np.ndarray] = []
        for snapshot, (picture, bare) in zip(moments, pictures, strict=True):
            log_frame, time_ns = self._log(picture), _ns(snapshot)
            if self._trace is None:
                self._state, found = dvs.step(self._state, log_frame, time_ns, config.dvs)
            else:
                old, self._trace = self._trace, self._traced(snapshot, bare, log_frame)
                blamed = self._blame(snapshot, old, self._trace)
                self._state, found, label = dvs.step_labelled(
                    self._state, log_frame, time_ns, config.dvs, blamed
                )
                labels.append(label)
            sensed.append(found)
        events = np.concatenate(sensed)
        dvs.add_counts(counts, events)
        return Sensed(counts, events, np.concatenate(labels) if config.label_events else None, *reached)

    def plan(self, before: Snapshot, after: Snapshot) -> Plan:
        """Spread renders so that the image's motion, and the change of the light where lightning strikes, is the same
        between any two, and at most what the config allows unless its cap on the renders is reached.

        Rain falls hundreds of its diameters in a step: no number of renders follows every drop. It is drawn as streaks
        that leave no gaps, the fainter the longer they are, and asks for as many renders as keep them below
        ``max_streak``; one cap is over flow, rain and lightning together, and what was reached is in the plan.
        """
        start_s, end_s = before.time_s, after.time_s
        view, settings = self._view, self._config.dvs
        flow = image_flow_px(view.camera, view.world.scenario.street, before, after)
        fall = view.streaks_per_s * (end_s - start_s)
        steps, cap = max(flow / settings.max_flow_px, fall / settings.max_streak), settings.max_subframes
        if view.lightning.dark(start_s, end_s):
            count = max(1, math.ceil(steps))
            count = count if cap is None else min(count, cap)
            times = [start_s + k * (end_s - start_s) / count for k in range(1, count)]
            return Plan([*times, end_s], flow / count, fall / count)
        grid = np.linspace(start_s, end_s, max(2, round((end_s - start_s) / LIGHT_GRID_S)))
        light = np.array([view.lightning.light_lx(float(t)) for t in grid]) + view.renderer.sky_lx
        changes = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(np.log(light))))]) / LIGHT_STEP
        progress = changes + steps * (grid - start_s) / (end_s - start_s)
        count = max(1, math.ceil(progress[-1]))
        count = count if cap is None else min(count, cap)
        inner = np.interp(progress[-1] * np.arange(1, count) / count, progress, grid)
        times = [float(t) for t in inner] + [end_s]
        longest = max(np.diff([start_s, *times])) / (end_s - start_s)
        return Plan(times, float(flow * longest), float(fall * longest))

    def _parted(self, before: Snapshot, after: Snapshot, instants: int, reached_px: float) -> list[Cadence]:
        """The layers that the step's pictures are put together from, none where the scene is rendered as a whole.

        Where the cap on renders lets what is nearest move farther between two than was asked for, what is farther away
        may do so too. Labels need all of every picture.
        """
        config, view = self._config, self._view
        whole = not config.dvs.layers or instants == 1 or self._trace is not None
        if whole or not view.by_layers(before, after):
            return []
        most_px = max(config.dvs.max_flow_px, reached_px)
        parts = self._parting.cadences(before, after, instants, most_px)
        return parts if len(parts) > 1 else []

    def _whole(
        self, before: Snapshot, moments: Sequence[Snapshot], depth: np.ndarray | None
    ) -> Iterator[tuple[Picture, np.ndarray | None]]:
        """Give ``_picture`` at each moment."""
        for earlier, snapshot in itertools.pairwise([before, *moments]):
            yield self._picture(snapshot, snapshot.time_s - earlier.time_s, depth)

    def _put_together(
        self, parts: list[Cadence], before: Snapshot, moments: Sequence[Snapshot]
    ) -> Iterator[tuple[Picture, None]]:
        """Give the picture at each moment, rendered in layers."""
        renderer, far = self._view.renderer, [part.layer for part in parts[1:]]
        lacking = [layer for layer in far if _key(layer, before.time_s) not in self._far]
        rendered = iter(renderer.layers(renderer.moments([before])[0], lacking) if lacking else [])
        later = renderer.moments(moments)
        first = [self._far.get(_key(layer, before.time_s)) or next(rendered) for layer in far]

        def render(instant: int, layers: list[Layer], *, passing: bool) -> list[Seen]:
            return renderer.layers(later[instant - 1], layers, passing=passing)

        pictures = Pictures(parts, first, len(moments), render)
        for picture in pictures:
            yield picture, None
        end_s = moments[-1].time_s
        self._far = {_key(layer, end_s): seen for layer, seen in zip(far, pictures.far, strict=True)}

    def _picture(
        self, snapshot: Snapshot, interval_s: float, depth: np.ndarray | None
    ) -> tuple[Picture, np.ndarray | None]:
        """Luminance with precipitation; and ln of it without, where events are labelled."""
        frame = self._view.luminance(snapshot, self._view.lightning.light_lx(snapshot.time_s))
        floor = self._config.dvs.log_floor_cd_m2
        bare = dvs.log_luminance(frame.luminance, floor) if self._config.label_events else None
        # Streaks are drawn as long as the drop falls between two renders: no gaps, hence no aliasing.
        self._view.precipitate(frame, snapshot, interval_s, depth)
        return whole_picture(frame.luminance), bare

    def _log(self, picture: Picture) -> np.ndarray:
        camera = self._config.camera
        return log_picture(picture, (camera.height_px, camera.width_px), self._config.dvs.log_floor_cd_m2)

    def _traced(self, snapshot: Snapshot, bare: np.ndarray | None, seen: np.ndarray) -> _Trace:
        flash_lx = self._view.lightning.light_lx(snapshot.time_s)
        frame = self._view.render(snapshot, flash_lx)
        return _Trace(frame, seen if bare is None else bare, seen, flash_lx)

    def _blame(self, snapshot: Snapshot, old: _Trace, new: _Trace) -> np.ndarray:
        """(H, W) int32: what each pixel's change between two renders is put down to; ``snapshot`` is the later."""
        unlit = new.bare
        if new.flash_lx != old.flash_lx:  # what would be seen had the light stayed
            unlit_frame = self._view.luminance(snapshot, old.flash_lx)
            unlit = dvs.log_luminance(unlit_frame.luminance, self._config.dvs.log_floor_cd_m2)
        owner = causes.edge_owner(old.frame, new.frame)
        return causes.blame(
            owner, scene=unlit - old.bare, precipitation=(new.seen - new.bare) - (old.seen - old.bare),
            lightning=new.bare - unlit,
        )  # fmt: skip


def _ns(snapshot: Snapshot) -> int:
    return round(snapshot.time_s * 1e9)


def _key(layer: Layer, time_s: float) -> Any:
    """What a render of a layer depends on."""
    return time_s, *layer[:4], None if layer.actors is None else layer.actors.tobytes()

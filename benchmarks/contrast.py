"""Contrast-to-noise of a pedestrian in the event frame and in the RGB frame, where light is hard and where it is easy.

A pedestrian crosses ahead of an ego at 30 km/h; both cameras are carried there as a car carries them: the RGB camera
with its automatic exposure and its lag for a second before, the event camera with ten renders a step. Then the last
1/30 s is sensed with many seeds of the sensors' noise. Frames: RGB as grey levels (0..255, Rec. 709 weights on the
8-bit picture), events as counts of both polarities. With P the pedestrian's pixels (RGB: at the end of the step;
events: at its start or end) and S what is beside them (in the same rows, from 2 px to half his height away):

    contrast  C = mean over P - mean over S
    clutter   standard deviation over S of the mean over noise seeds: what else there is to be taken for him
    noise     root of the mean over P and S of the variance over noise seeds
    CNR       |C| / standard deviation over S, both of one frame, mean over the seeds: as it is measured on a picture
              with a region of interest and one of background, clutter and noise together
    CNR of the sensor   |C| / noise: with nothing but the sensor's noise, as if the street without him were known

Both are called contrast-to-noise ratio. The second one has no meaning where a picture saturates, as clipping takes
the noise along with the contrast; "clipped" tells the share of P and S that is white in the RGB frame. The event
camera's seeds are other sensors too (thresholds differ between pixels); the RGB camera's pixels are alike. CNRs are
medians over scenes (streets, clothes, gait), with the least and the largest. The last lines hold the expectation,
that events lead at night beside glare and where a tunnel is left and RGB leads at clear noon, against either measure.

Run: python benchmarks/contrast.py [--scenes 8] [--noise-seeds 16] [--dvs davis346] [--pictures DIR]
"""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from scenes import car, walker

from pedcross_env.camera import Renderer
from pedcross_env.config import CameraConfig, RgbConfig
from pedcross_env.contracts import ACTOR_DTYPE, Snapshot
from pedcross_env.scenario.street import Crosswalk, StreetSpec
from pedcross_env.sensors import dvs, rgb
from pedcross_env.sensors.dvs_config import DVS_PRESETS, DvsConfig, dvs_preset
from pedcross_env.weather import as_weather

FPS = 30
EGO_MPS, WALK_MPS = 30 / 3.6, 1.4
NEAR_M, FAR_M, AFAR_M = 14.0, 28.0, 60.0
WALKER_X_M = 33.0
SETTLING_S = 1.0
RENDERS = (
    10  # per step: at 30 km/h flow beside the road is the largest, around the pedestrian well below 1 px
)
WARM_STEPS = 4
WALKER = 20
LUMA = np.array([0.2126, 0.7152, 0.0722])
WHITE = 254.5  # grey level; events never reach as many in a step


@dataclass(frozen=True)
class Situation:
    name: str
    weather: dict[str, object]
    lights: float  # of the cars: 1 with low beams on
    ahead_m: float  # from the ego's middle to the pedestrian
    event_wins: bool | None  # what is expected of the sensors; None: shown beside


SITUATIONS = (
    Situation("night beside glare", {"preset": "night"}, 1.0, NEAR_M, True),
    Situation("unlit night, glare", {"preset": "night_unlit"}, 1.0, NEAR_M, None),
    Situation(
        "tunnel, before its exit",
        {"preset": "tunnel_exit", "tunnel_exit_m": WALKER_X_M + 15},
        1.0,
        NEAR_M,
        True,
    ),
    Situation(
        "tunnel, beyond its exit",
        {"preset": "tunnel_exit", "tunnel_exit_m": WALKER_X_M - 3},
        1.0,
        FAR_M,
        True,
    ),
    Situation(
        "the same, from afar",
        {"preset": "tunnel_exit", "tunnel_exit_m": WALKER_X_M - 3},
        1.0,
        AFAR_M,
        True,
    ),
    Situation("clear noon, near", {"preset": "clear"}, 0.0, NEAR_M, False),
    Situation("clear noon, far", {"preset": "clear"}, 0.0, FAR_M, False),
)
ONCOMING_M = 8.0  # how far behind the pedestrian the oncoming car is
WALKER_Y_M = -0.1  # two degrees beside its nearer headlight, seen from the ego


@dataclass(frozen=True)
class Result:
    contrast: float
    noise: float
    clutter: float
    cnr: float
    clipped: float

    @property
    def cnr_sensor(self) -> float:
        return abs(self.contrast) / self.noise if self.noise > 0 else math.inf


def scene(situation: Situation, time_s: float, seed: int) -> Snapshot:
    """A pedestrian on his way to the left and a car behind him that comes towards the ego."""
    k = 100 * seed
    person = walker(WALKER, WALKER_X_M, WALKER_Y_M, time_s, WALK_MPS, height=1.75, seed=k + 1, model=seed % 2)
    person["gait_phase"] += seed / 8
    x = WALKER_X_M + ONCOMING_M - EGO_MPS * time_s
    other = car(12, x, 1.75, situation.lights, seed=k + 12, yaw=math.pi, model=seed % 3, speed=EGO_MPS)
    ego_x = WALKER_X_M - situation.ahead_m + EGO_MPS * time_s
    ego = car(1, ego_x, -1.75, situation.lights, speed=EGO_MPS)
    return Snapshot(time_s, ego, np.array([person, other], ACTOR_DTYPE))


def rgb_frames(
    renderer: Renderer, situation: Situation, seed: int, noise_seeds: int
) -> tuple[np.ndarray, np.ndarray]:
    """(noise seeds, H, W) grey levels at time 0, and one picture of them for the eye."""
    config = RgbConfig()
    state = rgb.initial_rgb_state(config)
    steps = round(SETTLING_S * FPS)
    for step in range(steps):
        frame = renderer.render(scene(situation, (step - steps) / FPS, seed))
        state, _ = rgb.expose(state, frame, 1 / FPS if step else 0.0, config, 0)
    frame = renderer.render(scene(situation, 0.0, seed))
    # The noise is drawn from the seed; exposure was decided by the frames before, the same for all.
    pictures = [rgb.expose(state, frame, 1 / FPS, config, 1 + n)[1] for n in range(noise_seeds)]
    return np.stack([picture @ LUMA for picture in pictures]), pictures[0]


def event_frames(
    renderer: Renderer, situation: Situation, seed: int, noise_seeds: int, config: DvsConfig
) -> np.ndarray:
    """(noise seeds, H, W, 2) counts of the step that ends at time 0."""
    times = [(k / RENDERS - WARM_STEPS - 1) / FPS for k in range((WARM_STEPS + 1) * RENDERS + 1)]
    frames = []
    for time_s in times:
        luminance = renderer.render(scene(situation, time_s, seed), luminance_only=True).luminance
        frames.append(dvs.log_luminance(luminance, config.log_floor_cd_m2))
    at_ns = [round((time_s - times[0]) * 1e9) for time_s in times]
    taken = []
    for n in range(noise_seeds):
        state = dvs.initial_state(frames[0], 0, config, 1 + n)
        counts = np.zeros((*frames[0].shape, 2), np.uint16)
        for k in range(1, len(frames)):
            if k == WARM_STEPS * RENDERS + 1:
                counts[:] = 0
            state, events = dvs.step(state, frames[k], at_ns[k], config)
            dvs.add_counts(counts, events)
        taken.append(counts)
    return np.stack(taken)


def masks(renderer: Renderer, situation: Situation, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(H, W) bool: the pedestrian at time 0, at time 0 or a step before, and what is beside him."""
    now, before = (
        renderer.render(scene(situation, time_s, seed)).instance == WALKER for time_s in (0.0, -1 / FPS)
    )
    either = now | before
    half = max(4, int(np.ptp(np.nonzero(now)[0])) // 2)
    shapes = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (5, 5)), np.ones((1, 2 * half + 1), np.uint8)
    near, wide = (cv2.dilate(either.astype(np.uint8), shape) for shape in shapes)
    return now, either, (wide > 0) & (near == 0)


def measure(frames: np.ndarray, person: np.ndarray, ring: np.ndarray) -> Result:
    """Hold (noise seeds, H, W) against the masks."""
    mean, variance = frames.mean(axis=0), frames.var(axis=0, ddof=1)
    contrast = frames[:, person].mean(axis=1) - frames[:, ring].mean(axis=1)
    spread = frames[:, ring].std(axis=1)
    return Result(
        contrast=float(contrast.mean()),
        noise=math.sqrt(0.5 * (variance[person].mean() + variance[ring].mean())),
        clutter=float(mean[ring].std()),
        cnr=float(np.mean(np.abs(contrast) / spread)) if spread.min() > 0 else math.inf,
        clipped=float((mean[person | ring] > WHITE).mean()),
    )


def look(
    situation: Situation, seed: int, noise_seeds: int, config: DvsConfig, pictures: Path | None
) -> tuple[Result, Result]:
    """RGB's and the event camera's result for one street."""
    renderer = Renderer(CameraConfig())
    weather = as_weather(situation.weather)
    street = StreetSpec(crosswalks=(Crosswalk(x_m=WALKER_X_M),), seed=seed)
    renderer.load(street, weather)
    now, either, ring = masks(renderer, situation, seed)
    grey, picture = rgb_frames(renderer, situation, seed, noise_seeds)
    counts = event_frames(renderer, situation, seed, noise_seeds, config)
    if pictures is not None:
        save(
            pictures / f"{situation.name.replace(' ', '_').replace(',', '')}_{seed}.png",
            picture,
            counts[0],
            ring,
        )
    return measure(grey, now, ring), measure(counts.sum(axis=3).astype(np.float64), either, ring)


def save(path: Path, picture: np.ndarray, counts: np.ndarray, ring: np.ndarray) -> None:
    """RGB, events and both close up."""
    strength = np.minimum(counts / 3, 1) @ (255 - np.array([[20, 90, 200], [205, 45, 40]]))
    events = np.clip(255 - strength, 0, 255).astype(np.uint8)
    rows, columns = np.nonzero(ring)
    box = slice(rows.min(), rows.max() + 1), slice(columns.min(), columns.max() + 1)
    close = [cv2.resize(im[box], (256, 256), interpolation=cv2.INTER_NEAREST) for im in (picture, events)]
    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), np.hstack([picture, close[0], events, close[1]])[..., ::-1])


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--scenes", type=int, default=8)
    parser.add_argument("--noise-seeds", type=int, default=16)
    parser.add_argument("--dvs", default="davis346", choices=sorted(DVS_PRESETS))
    parser.add_argument("--pictures", type=Path, default=None, help="folder for what both cameras saw")
    args = parser.parse_args()
    config = dvs_preset(args.dvs)
    print(f"event camera {args.dvs}; {args.scenes} scenes, {args.noise_seeds} noise seeds")
    print(
        f"{'situation':24s} {'frame':7s} {'contrast':>15s} {'clipped':>8s} {'noise':>6s} {'clutter':>8s}",
        end="",
    )
    print(f" {'CNR':>22s} {'CNR of the sensor':>22s}")
    verdicts = []
    for situation in SITUATIONS:
        pairs = [
            look(situation, seed, args.noise_seeds, config, args.pictures) for seed in range(args.scenes)
        ]
        for column, kind in enumerate(("RGB", "events")):
            text = line(situation.name if column == 0 else "", kind, [pair[column] for pair in pairs])
            print(text, flush=True)
        if situation.event_wins is not None:
            verdicts.append(verdict(situation, pairs))
    print("\nIs it as expected? Scenes in which events lead, by CNR and by CNR of the sensor:")
    print("\n".join(verdicts))


def verdict(situation: Situation, pairs: list[tuple[Result, Result]]) -> str:
    """Whether the camera that is expected to lead does so in most scenes, by either measure."""
    words = []
    for measure in ("cnr", "cnr_sensor"):
        wins = sum(getattr(events, measure) > getattr(grey, measure) for grey, events in pairs)
        holds = wins > len(pairs) / 2 if situation.event_wins else wins < len(pairs) / 2
        words.append(f"{wins} of {len(pairs)}: {'yes' if holds else 'no'}")
    wanted = "events" if situation.event_wins else "RGB"
    return f"{situation.name:24s} {wanted:7s} {words[0]:>15s} {words[1]:>15s}"


def line(name: str, kind: str, results: list[Result]) -> str:
    """One row of the table."""
    contrast = np.array([r.contrast for r in results])
    noise, clutter, clipped = (
        np.mean([getattr(r, n) for r in results]) for n in ("noise", "clutter", "clipped")
    )
    share = f"{100 * clipped:6.0f} %" if kind == "RGB" else ""
    text = f"{name:24s} {kind:7s} {contrast.mean():7.2f} +-{contrast.std():5.2f} {share:>8s}"
    text += f" {noise:6.2f} {clutter:8.2f}"
    for measure in ("cnr", "cnr_sensor"):
        values = np.array([getattr(r, measure) for r in results])
        text += f" {np.median(values):8.2f} ({values.min():.2f}..{values.max():.2f})".ljust(23)
    return text


if __name__ == "__main__":
    main()

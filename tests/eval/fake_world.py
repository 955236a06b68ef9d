"""A street with one dimension and no sensors, whose collisions can be worked out by hand.

The ego starts at 10 m/s, 40 m before the crossing. With an even seed somebody is on the carriageway from 1 s
to 6 s and is hit if the ego arrives then, i.e. at 4 s if it never brakes. Brakes act at once.
"""

import math

import gymnasium
import numpy as np

STEP_S = 1 / 30
CROSSING_M = 40.0
START_S, END_S = 1.0, 6.0
DECELERATION = {"clear": 9.0, "rain": 1.0}


class FakeEnv(gymnasium.Env):
    made = 0

    def __init__(self, config):
        type(self).made += 1
        self.config = config

    def reset(self, *, seed=None, options=None):
        self.seed, self.weather = seed, options["weather"]
        self.steps, self.position, self.speed, self.acceleration = 0, 0.0, 10.0, 0.0
        self.outcome, self.impact = "running", -1.0
        return self._observation(), self._info()

    def step(self, action):
        a = float(action[0])
        self.acceleration = a * (3.0 if a > 0 else DECELERATION[self.weather])
        before = self.speed
        self.speed = max(0.0, self.speed + self.acceleration * STEP_S)
        self.acceleration = (self.speed - before) / STEP_S
        self.position += self.speed * STEP_S
        self.steps += 1
        if self._label() and self.position >= CROSSING_M:
            self.outcome, self.impact = "collision", self.speed
        elif self.position >= CROSSING_M + 10:
            self.outcome = "passed"
        elif self.steps >= 300:
            self.outcome = "timeout"
        done = self.outcome in ("collision", "passed")
        return self._observation(), 0.0, done, self.outcome == "timeout", self._info()

    def _time(self):
        return self.steps * STEP_S

    def _crosses(self):
        return self.seed % 2 == 0

    def _label(self):
        return self._crosses() and START_S <= self._time() <= END_S and self.position < CROSSING_M + 1

    def _observation(self):
        seen = 255 * int(self._label())
        image = {m: np.full((1, 1, 3 if m == "rgb" else 2), seen, np.uint8) for m in self.config.modalities}
        return image | {"ego": np.array([self.speed, self.acceleration, 0.0], np.float32)}

    def _info(self):
        time_s = self._time()
        later = math.inf if not self._crosses() or time_s > END_S else max(0.0, START_S - time_s)
        return {
            "time_s": time_s, "episode_seed": self.seed, "scenario": "fake", "weather": self.weather,
            "crossing": int(self._label()), "crossing_in_s": later, "visible_fraction": -1.0,
            "conflict": False, "ttc_s": math.inf, "drac_mps2": 0.0, "pet_s": math.inf,
            "distance_m": CROSSING_M - self.position,
            "speed_mps": self.speed, "acceleration_mps2": self.acceleration, "demand_mps2": 0.0,
            "position_m": self.position, "impact_speed_mps": self.impact, "collided_with": 0,
            "outcome": self.outcome, "subframes": 0, "renders": 0, "flow_px": -1.0, "streak": -1.0,
        }  # fmt: skip


class FakeDetector:
    """Sees the label in its image; "blind" nothing; "jumpy" cries at 0.2-0.4 s too, "hasty" at once; "broken": nan."""

    modality, frames = "rgb", 3

    def __init__(self, path):
        self.name = path

    def reset(self):
        self.updates = 0

    def update(self, observation):
        self.updates += 1
        if self.name == "broken":
            return math.nan
        if self.name == "hasty":
            return float(self.updates < self.frames)
        if self.name == "jumpy" and 6 <= self.updates <= 12:
            return 1.0
        return 0.0 if self.name == "blind" else float(observation["rgb"][0, 0, 0]) / 255

    def predict(self, clips):
        if self.name == "blind":
            return np.zeros(len(clips))
        return clips.reshape(len(clips), -1).max(axis=1) / 255.0

"""The world of one episode: steps at the policy's rate, knows all poses at any time within a step."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from pedcross_env.config import CameraConfig, EgoConfig, LabelConfig, WorldConfig, require
from pedcross_env.contracts import Outcome, Snapshot
from pedcross_env.errors import ConfigError, PedcrossError
from pedcross_env.scenario.layout import carriageway_m, to_street
from pedcross_env.scenario.scenario import Scenario
from pedcross_env.scenario.trigger import Trigger
from pedcross_env.world.actors import ActorRecords
from pedcross_env.world.collision import CollisionFinder
from pedcross_env.world.contact import STANDING_MPS
from pedcross_env.world.crossing import ConflictFinder, crossing_stays
from pedcross_env.world.drive import Drive
from pedcross_env.world.ego import EgoState
from pedcross_env.world.encounters import Encounters
from pedcross_env.world.pedestrians import PedestrianPoses, Pedestrians
from pedcross_env.world.traffic import Traffic
from pedcross_env.world.view import CameraView

__all__ = ["MOST_DRAC_MPS2", "World"]

MOST_DRAC_MPS2 = 1000.0
"""What the deceleration rate to avoid a crash is cut off at: no brake reaches a hundredth of it."""

_TIME_SLACK_S = 1e-9


class World:
    """Ego, vehicles and pedestrians of one scenario.

    The ego keeps to its way, its lane or a turn through the intersection, unless its config lets it steer; who then
    leaves the carriageway has ended the episode. A contact ends the episode at its moment, found inside the step:
    all poses stay as they were then. Contact with an ego slower than 0.1 m/s (somebody walks or drives into a
    standing car) is no collision.

    Args:
        scenario: What happens.
        ego: The ego's size and actuator.
        world: Clock rates.
        label: When a frame is positive, and when the ego is in conflict.
        friction: Highest acceleration of the ego over g.
        camera: The one the label is made for.
        headlights: Whether vehicles that drive have their low beams on.

    Raises:
        ConfigError: For a friction out of range, or a vehicle that cannot drive where it is put.
    """

    def __init__(
        self,
        scenario: Scenario,
        *,
        ego: EgoConfig,
        world: WorldConfig,
        label: LabelConfig,
        friction: float,
        camera: CameraConfig | None = None,
        headlights: bool = False,
    ) -> None:
        self.scenario = scenario
        self._config, self._clock, self._label = ego, world, label
        self._view = CameraView(camera if camera is not None else CameraConfig())
        self._drive = Drive(scenario, ego, friction=friction)
        self._people = Pedestrians(scenario.pedestrians, scenario.street)
        self._traffic = Traffic(scenario, ego, self._people)
        self._records = ActorRecords(scenario, ego, self._traffic, headlights=headlights)
        self._encounters = Encounters(self._drive.plan, ego)
        self._foresee()
        self._watching = self._people.waiting
        self._collisions = CollisionFinder(
            scenario,
            ego,
            drive=self._drive,
            people=self._people,
            traffic=self._traffic,
            longest_step_s=1.0 / world.tick_hz,
        )
        self._steps, self._step_start_s, self._demand_mps2 = 0, 0.0, 0.0
        self._contact_s: float | None = None
        self.outcome = Outcome.RUNNING
        self.impact_speed_mps = math.nan
        self.collided_with = 0
        self._now: tuple[EgoState, PedestrianPoses, np.ndarray] | None = None
        self._positive: tuple[np.ndarray, np.ndarray] | None = None

    def _foresee(self) -> None:
        """Find stays and conflicts of all walks as they are known now."""
        people, duration = self._people, self.scenario.duration_s
        self._conflicts = ConflictFinder(people, self._config, self._label, duration_s=duration)
        self._encounters.foresee(people.walks, people.footprints_m)
        stays = [
            (index, stay.start_s, stay.end_s)
            for index, walk in enumerate(people.walks)
            for stay in crossing_stays(walk, self.scenario.street, self._drive.plan)
            if stay.start_s < duration
        ]
        self._stay_owner = np.array([s[0] for s in stays], dtype=np.int64)
        self._stay_start_s = np.array([s[1] for s in stays], dtype=np.float64)
        self._stay_end_s = np.array([s[2] for s in stays], dtype=np.float64)

    @property
    def time_s(self) -> float:
        """Time since reset: the end of the last policy step."""
        return self._steps / self._clock.policy_hz

    @property
    def contact_time_s(self) -> float:
        """When the collision happened, nan without one."""
        return math.nan if self._contact_s is None else self._contact_s

    @property
    def ego(self) -> EgoState:
        """The ego now (at the moment of contact after a collision)."""
        return self._present()[0]

    def _present(self) -> tuple[EgoState, PedestrianPoses, np.ndarray]:
        """(state of the ego, poses of the pedestrians, record of the ego) now."""
        if self._now is None:
            time = self._pose_time(self.time_s)
            state = self._drive.state(time)
            self._now = state, self._people.poses(time), self._records.ego(state, self._drive.pose(time))
        return self._now

    @property
    def front_m(self) -> float:
        """How far the ego's front has come along its planned way."""
        return self._drive.front_m(self._pose_time(self.time_s))

    def _pose_time(self, time_s: float) -> float:
        return time_s if self._contact_s is None else min(time_s, self._contact_s)

    def step(self, demand_mps2: float, steer: float = 0.0) -> None:
        """Advance by one policy step.

        Args:
            demand_mps2: Acceleration asked for, clipped to what the ego can do; 0 holds the speed.
            steer: Share of the largest angle of the front wheels, -1 (right) to 1; of no effect unless the
                ego's config has ``steering``.

        Raises:
            PedcrossError: After the end of the episode.
            ConfigError: For a demand that is not finite.
        """
        if self.outcome is not Outcome.RUNNING:
            raise PedcrossError(
                f"the episode ended ({self.outcome.value}) at {self.time_s:.3f} s: make a new World."
            )
        require(math.isfinite(demand_mps2), "demand_mps2", demand_mps2, "finite")
        require(abs(steer) <= 1, "steer", steer, "-1 to 1")
        start, end = self.time_s, (self._steps + 1) / self._clock.policy_hz
        low, high = -self._config.max_deceleration_mps2, self._config.max_acceleration_mps2
        self._demand_mps2 = float(min(high, max(low, demand_mps2)))
        self._drive.step(self._demand_mps2, steer, end)
        self._traffic.forget(start)
        self._let_others_act(start, end)
        self._step_start_s, self._now, self._positive = start, None, None
        self._steps += 1
        self._conclude(start, end)
        self._encounters.advance(start, self._pose_time(end), self._drive.front_m)

    def _let_others_act(self, start_s: float, end_s: float) -> None:
        """Drivers decide and triggers fire, in the order of time, whatever the policy's rate."""
        now = start_s
        while now < end_s - _TIME_SLACK_S:
            self._traffic.decide_until(now + 2 * _TIME_SLACK_S, self._drive.seen_by_others, self._fires)
            until = min(end_s, self._traffic.next_decision_s)
            self._traffic.doors.watch(self._fires, until)
            if self._watching and self._people.watch(now, until, self._fires):
                self._watching = self._people.waiting
                self._traffic.see_people()
                self._foresee()
            now = until

    def _fires(self, trigger: Trigger, place: tuple[float, float, float], time_s: float) -> bool:
        """Whether a trigger's conditions hold for an actor at (x, y, heading), at a time of the present step."""
        x_m, y_m, heading = place
        if trigger.time_s is not None and time_s < trigger.time_s - _TIME_SLACK_S:
            return False
        if trigger.reached_x_m is not None and (x_m - trigger.reached_x_m) * math.cos(heading) < 0:
            return False
        speed = self._drive.motion.motion(time_s)[1]
        along = x_m if self._drive.plan.straight else self._drive.plan.project(x_m, y_m)[0]
        ahead = along - self._drive.front_m(time_s)
        if trigger.distance_m is not None and not 0 <= ahead <= trigger.distance_m:
            return False
        if trigger.ttc_s is not None and not 0 <= ahead <= trigger.ttc_s * speed:
            return False
        if trigger.ego_below_mps is not None and speed >= trigger.ego_below_mps:
            return False
        if trigger.gap_s is None:
            return True
        comes = -self._config.length_m <= ahead < max(speed * trigger.gap_s, 0.5 * (speed > STANDING_MPS))
        return not comes and self._traffic.arrives_in_s(x_m, y_m, time_s) > trigger.gap_s

    def _conclude(self, start_s: float, end_s: float) -> None:
        finish = self.scenario.finish_x_m
        passed = self._drive.front_m(end_s) > finish
        if passed:  # a contact after the finish is none of this episode
            end_s = self._reaches_s(finish, start_s, end_s)
        contact = self._collisions.first(start_s, end_s)
        if contact is not None:
            self._contact_s, walks, index = contact
            ids = self._records.pedestrian_ids if walks else self._records.vehicle_ids
            self.collided_with = int(ids[index])
            self.impact_speed_mps = self._drive.motion.motion(self._contact_s)[1]
            self.outcome = Outcome.COLLISION
        elif self._config.steering and self._off_road(end_s):
            self.outcome = Outcome.OFF_ROAD
        elif passed:
            self.outcome = Outcome.PASSED
        elif self.time_s >= self.scenario.duration_s - _TIME_SLACK_S:
            self.outcome = Outcome.TIMEOUT

    def _off_road(self, time_s: float) -> bool:
        x, y, _ = self._drive.pose(time_s)
        return bool(carriageway_m(self.scenario.street, x, y) < 0)

    def _reaches_s(self, front_m: float, low_s: float, high_s: float) -> float:
        while high_s - low_s > _TIME_SLACK_S:
            middle = 0.5 * (low_s + high_s)
            low_s, high_s = (low_s, middle) if self._drive.front_m(middle) > front_m else (middle, high_s)
        return high_s

    def snapshot(self, time_s: float) -> Snapshot:
        """All poses at a time within the last policy step, both ends included.

        Raises:
            ConfigError: For a time outside of it.
        """
        return self.snapshots((time_s,))[0]

    def snapshots(self, times_s: Sequence[float]) -> list[Snapshot]:
        """The same snapshots for several times, sooner than one by one."""
        if not times_s:
            return []
        at = [self._within_step(time_s) for time_s in times_s]
        actors = self._records.actors(
            [self._traffic.poses(time) for time in at], self._people.poses(np.array(at)),
            [self._traffic.doors.poses(time) for time in at],
        )  # fmt: skip
        egos = (self._records.ego(self._drive.state(time), self._drive.pose(time)) for time in at)
        return [Snapshot(*moment) for moment in zip(times_s, egos, actors, strict=True)]

    def _within_step(self, time_s: float) -> float:
        if not self._step_start_s - _TIME_SLACK_S <= time_s <= self.time_s + _TIME_SLACK_S:
            raise ConfigError(
                f"snapshot time_s = {time_s!r} is not allowed: it must be within the last step, "
                f"{self._step_start_s} to {self.time_s}."
            )
        return self._pose_time(time_s)

    def _labelled(self) -> tuple[np.ndarray, np.ndarray]:
        """(indices, distances) of the pedestrians that make the frame positive now, nearest first."""
        if self._positive is None:
            self._positive = self._found_positive()
        return self._positive

    def _found_positive(self) -> tuple[np.ndarray, np.ndarray]:
        time = self._pose_time(self.time_s)
        owners = np.unique(self._stay_owner[(self._stay_start_s <= time) & (time < self._stay_end_s)])
        if owners.size == 0:
            return owners, np.zeros(0)
        _, people, ego = self._present()
        x, y = people.x[owners], people.y[owners]
        heading = float(ego["yaw"])
        ahead = (x - ego["x"]) * math.cos(heading) + (y - ego["y"]) * math.sin(heading)
        ahead -= 0.5 * self._config.length_m
        seen = (ahead > 0) & (ahead <= self._label.range_m)
        seen &= self._view.shows(ego, x, y, self._people.heights_m[owners])
        order = np.argsort(ahead[seen], kind="stable")
        return owners[seen][order], ahead[seen][order]

    def crossing_ids(self) -> tuple[int, ...]:
        """Actor ids of the pedestrians that make the label 1, nearest first."""
        return tuple(int(i) for i in self._records.pedestrian_ids[self._labelled()[0]])

    def full_crossings_s(self) -> list[float]:
        """How long those take who, as it is known now, go all the way from one kerb to the other."""
        street, taken = self.scenario.street, []
        kerb = street.kerb_y_m
        for owner, start_s, end_s in zip(self._stay_owner, self._stay_start_s, self._stay_end_s, strict=True):
            if start_s > 0 and math.isfinite(end_s):
                walk = self._people.walks[owner]
                enters, leaves = (float(to_street(street, *walk.position(t))[1]) for t in (start_s, end_s))
                if enters * leaves < 0 and min(abs(enters), abs(leaves)) > 0.9 * kerb:
                    taken.append(float(end_s - start_s))
        return taken

    def _crossing_in_s(self) -> float:
        """Time until a pedestrian ahead steps onto the carriageway to cross; 0: one is on it, nan: never."""
        if self._stay_owner.size == 0:
            return math.nan
        people, front = self._present()[1], self.front_m
        time = self._pose_time(self.time_s)
        coming = np.flatnonzero(self._stay_end_s > time)
        owners = self._stay_owner[coming]
        along = self._drive.plan.projections(people.x[owners], people.y[owners])[0]
        coming = coming[along > front]
        if coming.size == 0:
            return math.nan
        return float(max(0.0, self._stay_start_s[coming].min() - time))

    def _conflict(self) -> tuple[float, float]:
        """(time to contact, deceleration rate to avoid it) of an ego that holds its speed on its way; inf, 0: none.

        DRAC (Cooper and Ferguson, 1976; for crossings as v^2 / 2d): the constant deceleration that, begun now, would
        just end the approach at the place of contact: v^2 / (2 v TTC) for a pedestrian, closing speed^2 / (2 gap) for
        a vehicle.
        """
        time, ego = self._pose_time(self.time_s), self.ego
        horizon = self._label.conflict_horizon_s
        way = self._drive.onward(time)
        ttc = self._conflicts.time_to_contact_s(time, ego.x_m, ego.speed_mps, way)
        drac = _drac(ego.speed_mps, ego.speed_mps * ttc) if ttc <= horizon else 0.0
        soonest, gap, closing = self._collisions.vehicle_ahead(
            time, ego.speed_mps, self._label.conflict_margin_m
        )
        if soonest <= horizon:
            drac = max(drac, _drac(closing, gap))
        return min(ttc, soonest), drac

    def facts(self) -> dict[str, Any]:
        """What the world knows of INFO_KEYS, now: plain scalars."""
        ego = self.ego
        labelled, distances = self._labelled()
        ttc, drac = self._conflict()
        horizon = self._label.conflict_horizon_s
        return {
            "time_s": self.time_s,
            "crossing": int(labelled.size > 0),
            "crossing_in_s": self._crossing_in_s(),
            "conflict": ttc <= horizon,
            "ttc_s": ttc if ttc <= horizon else math.inf,
            "drac_mps2": drac,
            "pet_s": self._encounters.pet_s,
            "distance_m": float(distances[0]) if distances.size else math.inf,
            "speed_mps": ego.speed_mps,
            "acceleration_mps2": ego.acceleration_mps2,
            "demand_mps2": self._demand_mps2,
            "position_m": self.front_m,
            "impact_speed_mps": self.impact_speed_mps,
            "collided_with": self.collided_with,
            "outcome": self.outcome.value,
        }


def _drac(closing_mps: float, gap_m: float) -> float:
    """Deceleration that ends an approach within a gap; MOST_DRAC_MPS2 where the gap is closed."""
    if closing_mps <= 0:
        return 0.0
    return min(MOST_DRAC_MPS2, closing_mps * closing_mps / max(2.0 * gap_m, 1e-9))

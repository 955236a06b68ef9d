"""The ego in the world: its motion along its way, and the way itself, planned or steered."""

from __future__ import annotations

import math

from pedcross_env.config import EgoConfig
from pedcross_env.scenario.layout import lane_route, turning_route
from pedcross_env.scenario.route import Route
from pedcross_env.scenario.scenario import Scenario
from pedcross_env.world.ego import EgoMotion, EgoState
from pedcross_env.world.steering import Steering

__all__ = ["Drive", "planned_route"]


def planned_route(scenario: Scenario) -> Route:
    """Return the way the ego is to take: its lane, or through the intersection as ``ego_turn`` says."""
    if scenario.ego_turn == "straight":
        return lane_route(scenario.street, scenario.street.ego_lane_y_m)
    return turning_route(scenario.street, scenario.ego_turn)


class Drive:
    """Where the ego is, at any time within the present policy step.

    Args:
        scenario: Where it starts, how fast and on which way.
        config: Its actuators.
        friction: Highest acceleration over g.

    Attributes:
        plan: The way it is to take.
        route: The way it takes: the plan, unless actions steer.
        motion: Along ``route``.
    """

    def __init__(self, scenario: Scenario, config: EgoConfig, *, friction: float) -> None:
        self.plan = planned_route(scenario)
        self.motion = EgoMotion(
            config, friction=friction, x_m=scenario.ego_x_m, speed_mps=scenario.ego_speed_mps
        )
        self._half_length_m = 0.5 * config.length_m
        self._config = config
        self._steering = None
        if config.steering:
            start = self.plan.pose(scenario.ego_x_m)
            self._steering = Steering(config, friction=friction, motion=self.motion, start=start)
        self.route = self._steering.route if self._steering else self.plan

    @property
    def straight(self) -> bool:
        """Whether the ego drives on a straight line, whatever it does."""
        return self._steering is None and self.plan.straight

    def step(self, demand_mps2: float, steer: float, end_s: float) -> None:
        """Drive to ``end_s``; ``steer`` is the share of the largest angle, to the left positive."""
        self.motion.begin(demand_mps2)
        self.motion.advance(end_s)
        if self._steering is not None:
            self._steering.begin(steer * self._config.max_steer_rad)
            self._steering.advance(end_s)

    def pose(self, time_s: float) -> tuple[float, float, float]:
        """(x, y, heading) of the centre."""
        return self.route.pose(self.motion.motion(time_s)[0])

    def seen_by_others(self, time_s: float) -> tuple[float, float, float, float]:
        """(x, y, heading, speed)."""
        return *self.pose(time_s), self.motion.motion(time_s)[1]

    def state(self, time_s: float) -> EgoState:
        """Speed, acceleration and the like."""
        return self.motion.state(time_s)

    def front_m(self, time_s: float) -> float:
        """How far the front has come along the planned way."""
        s = self.motion.motion(time_s)[0]
        if self._steering is not None:
            s = self.plan.project(*self.route.pose(s)[:2])[0]
        return s + self._half_length_m

    def onward(self, time_s: float) -> Route:
        """The way the ego keeps to if nothing changes: the plan, or as its wheels stand."""
        if self._steering is None:
            return self.plan
        s = self.motion.motion(time_s)[0]
        return Route([(math.inf, self._steering.curvature_per_m)], start=self.route.pose(s), start_m=s)

    def sharpest_per_m(self, start_s: float, end_s: float) -> float:
        """Largest curvature driven between two times of the present step."""
        if self.straight:
            return 0.0
        return self.route.sharpest_per_m(self.motion.motion(start_s)[0], self.motion.motion(end_s)[0])

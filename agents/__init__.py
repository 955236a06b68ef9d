"""Observation and p(crossing) in, action out.

``policy`` holds the protocol, ``aeb`` the braking logic that every detector shares, ``controls`` the
reference sources of p(crossing) that need no network, ``drivers`` a cruise control and a late human.
"""

from agents.aeb import AebConfig, AebPolicy, AebState
from agents.controls import CONTROLS, ControlDetector, braking_policy, make_control
from agents.drivers import CruiseDriver, HumanConfig, HumanDriver
from agents.policy import Policy

__all__ = [
    "CONTROLS",
    "AebConfig",
    "AebPolicy",
    "AebState",
    "ControlDetector",
    "CruiseDriver",
    "HumanConfig",
    "HumanDriver",
    "Policy",
    "braking_policy",
    "make_control",
]

"""What moves: the ego and its brakes, other vehicles, pedestrians; contact, label and conflict."""

from pedcross_env.world.ego import EgoState
from pedcross_env.world.world import World

__all__ = ["EgoState", "World"]

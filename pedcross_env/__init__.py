"""pedcross: closed-loop evaluation of pedestrian-crossing detectors in bad weather.

Importing this package registers ``pedcross/Crossing-v0`` with Gymnasium.
"""

from gymnasium.envs.registration import register, registry

__all__ = ["__version__"]

__version__ = "0.1.0"

if "pedcross/Crossing-v0" not in registry:
    register(id="pedcross/Crossing-v0", entry_point="pedcross_env.env:CrossingEnv")

"""pedcross: closed-loop evaluation of pedestrian-crossing detectors in bad weather.

Importing this package registers ``pedcross/Crossing-v0`` and ``pedcross/Suite-v0`` with Gymnasium.
"""

from gymnasium.envs.registration import register, registry

__all__ = ["__version__"]

__version__ = "0.1.0"

for _id, _entry_point in (
    ("pedcross/Crossing-v0", "pedcross_env.env:CrossingEnv"),
    ("pedcross/Suite-v0", "pedcross_env.suite_env:SuiteEnv"),
):
    if _id not in registry:
        register(id=_id, entry_point=_entry_point)

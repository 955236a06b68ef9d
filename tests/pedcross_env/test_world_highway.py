"""highway-env without its environments: nothing is missing to who uses both."""

import json
import subprocess
import sys

_REGISTERED = """
import gymnasium, highway_env, json
print(json.dumps(sorted(repr(spec) for spec in gymnasium.registry.values() if "highway_env" in str(spec.entry_point))))
"""


def _printed(code):
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return json.loads(run.stdout.splitlines()[-1])


def test_the_environment_imports_neither_pandas_nor_matplotlib():
    loaded = _printed("import json, sys, pedcross_env.env; print(json.dumps(list(sys.modules)))")
    assert {"pandas", "matplotlib", "highway_env"} & set(loaded) == {"highway_env"}


def test_highway_envs_own_environments_are_registered_as_without_us():
    alone = _printed(_REGISTERED)
    assert len(alone) > 10
    assert _printed("import pedcross_env.env" + _REGISTERED) == alone
    assert _printed("import highway_env, pedcross_env.env" + _REGISTERED) == alone


def test_highway_envs_own_environments_can_be_made_and_share_their_roads_with_us():
    code = """
import json, pedcross_env.env, gymnasium, highway_env
from pedcross_env.world.highway import Road
made = gymnasium.make("highway-v0"), gymnasium.make("intersection-multi-agent-v1")
made[0].reset(seed=0)
print(json.dumps([isinstance(made[0].unwrapped.road, Road), highway_env.envs.HighwayEnv.__name__,
                  isinstance(made[1], highway_env.envs.common.abstract.MultiAgentWrapper)]))
"""
    assert _printed(code) == [True, "HighwayEnv", True]

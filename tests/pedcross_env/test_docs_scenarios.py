"""The page on scenarios does what it says."""

import re
from pathlib import Path

import numpy as np

PAGE = (Path(__file__).parents[2] / "docs/scenarios.md").read_text()
BLOCKS = re.findall(r"```python\n(.*?)```", PAGE, re.S)


def test_the_page_runs_and_its_oracle_lets_the_child_go():
    first, *others = BLOCKS
    lines = [line for line in first.splitlines() if line.strip()]
    assert len(lines) < 30
    names: dict = {}
    exec(first, names)
    assert names["info"]["outcome"] == "passed"
    env, reveal = names["env"], names["reveal"]
    _, info = env.reset(seed=0, options={"scenario": reveal, "weather": "rain"})
    while info["outcome"] == "running":
        *_, info = env.step(np.zeros(1))
    assert info["outcome"] == "collision"
    for block in others:
        exec(block, names)
    assert repr(names["first"]) == repr(names["again"])

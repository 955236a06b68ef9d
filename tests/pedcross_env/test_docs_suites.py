"""The page on suites does what it says."""

import contextlib
import io
import re
from pathlib import Path

import pytest

from pedcross_env.contracts import INFO_KEYS, Outcome
from pedcross_env.scenario.suites import SUITES, suite

PAGE = (Path(__file__).parents[2] / "docs" / "suites.md").read_text()


def test_the_scenario_of_the_page_runs_in_less_than_thirty_lines():
    code = re.findall(r"```python\n(.*?)```", PAGE, flags=re.DOTALL)[1]
    scenario, _ = code.split("env = ")
    assert len([line for line in scenario.splitlines() if line.strip()]) < 30
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(code, {})
    outcome, time_s, _ = printed.getvalue().split()
    assert outcome in set(Outcome)
    assert 2.0 < float(time_s) <= 10.0


@pytest.mark.parametrize("name", SUITES)
def test_the_table_counts_the_cells(name):
    row = next(line for line in PAGE.splitlines() if line.startswith(f"| `{name}` |"))
    assert int(row.split("|")[2]) == len(suite(name).cells)


def test_the_total_is_the_sum():
    assert (
        f"each of the {sum(cell.hits for name in SUITES for cell in suite(name).cells)} hits"
        in PAGE.replace("\n", " ")
    )


def test_measures_named_are_measures_given():
    section = PAGE.split("## What every step says")[1].split("## The car")[0]
    named = re.findall(r"^\| `(\w+)` \|", section, flags=re.MULTILINE)
    assert len(named) >= 10
    assert set(named) <= set(INFO_KEYS)


def test_cells_named_exist():
    ids = {cell.id for name in SUITES for cell in suite(name).cells}
    for cell in ("CPNA-25/40/night", "PED-RIGHT-50/40/high", "CPNCO-50/30/heading-20", "CPNCO-50/40"):
        assert f"{cell}" in PAGE
        assert cell in ids

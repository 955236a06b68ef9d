import subprocess
import sys

import pytest

from eval import cli
from pedcross_env.errors import DataError
from pedcross_env.scenario.suites import SUITES, suite


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["evalute"], "Did you mean 'evaluate'"),
        (["evaluate", "--out", "{out}", "--controls", "oracel"], "Did you mean 'oracle'"),
        (
            ["evaluate", "--out", "{out}", "--detectors", "no-such-detector"],
            "unknown detector 'no-such-detector'",
        ),
        (["evaluate", "--out", "{out}", "--weathers", "rane"], "Did you mean 'rain'"),
        (["evaluate", "--out", "{out}", "--episodes", "0"], "episodes = 0"),
        (["demo", "--out", "{out}", "--weathers", "fgo"], "Did you mean 'fog'"),
        (["generate", "--out", "{file}/data", "--videos", "1"], "cannot be written"),
        (["generate", "--out", "{out}", "--subsets", "defualt"], "Did you mean 'default'"),
        (["report", "--out", "{out}"], "holds no results"),
        (["play", "--driver", "orcale"], "Did you mean 'oracle'"),
        (["play", "--out", "{out}/a.gif", "--seed", "1"], ".mp4 or .avi"),
        (["events", "{file}"], "is empty"),
        (["events", "{out}"], "does not exist"),
        (["events", "{file}", "--camera", "davis"], "Did you mean 'davis346'"),
        (["decimation", "--weather", "rane"], "Did you mean 'rain'"),
        (["decimation", "--width-px", "2000"], "width_px = 2000 is not allowed: it must be 1 to 1600"),
        (["weathers", "--fog"], "takes no options"),
        (["warmup", "now"], "takes no options"),
    ],
)
def test_a_mistake_is_one_line_on_stderr_and_exit_code_2(tmp_path, capsys, arguments, message):
    (tmp_path / "file").touch()
    places = {"out": str(tmp_path / "out"), "file": str(tmp_path / "file")}
    assert cli.main([argument.format(**places) for argument in arguments]) == 2
    printed = capsys.readouterr()
    assert printed.err.startswith("error: ")
    assert message in printed.err
    assert "Traceback" not in printed.err + printed.out


def test_an_unknown_flag_names_the_nearest_and_exits_with_2(capsys):
    with pytest.raises(SystemExit) as stop:
        cli.main(["report", "--otu", "x"])
    assert stop.value.code == 2
    assert "--out" in capsys.readouterr().err


def test_an_interrupt_ends_with_130_and_says_how_to_go_on(capsys, monkeypatch):
    def interrupted(arguments, console):
        raise KeyboardInterrupt

    monkeypatch.setitem(cli.COMMANDS, "weathers", ("", interrupted))
    assert cli.main(["weathers"]) == 130
    assert "goes on" in capsys.readouterr().err


def test_a_damaged_file_and_a_full_disk_are_errors_not_stack_traces(capsys, monkeypatch):
    for error in (DataError("clip.png: truncated"), OSError(28, "No space left on device", "out/x")):

        def fail(arguments, console, error=error):
            raise error

        monkeypatch.setitem(cli.COMMANDS, "weathers", ("", fail))
        assert cli.main(["weathers"]) == 2
        assert capsys.readouterr().err.startswith("error: ")


def test_a_programming_error_is_not_hidden(monkeypatch):
    def fail(arguments, console):
        raise ZeroDivisionError

    monkeypatch.setitem(cli.COMMANDS, "weathers", ("", fail))
    with pytest.raises(ZeroDivisionError):
        cli.main(["weathers"])


@pytest.mark.parametrize("arguments", [[], ["--help"], ["-h"]])
def test_help_lists_every_command(capsys, arguments):
    assert cli.main(arguments) == 0
    printed = capsys.readouterr().out
    assert all(f"  {name} " in printed for name in cli.COMMANDS)


def test_help_imports_nothing_heavy():
    code = (
        "import sys; from eval.cli import main; main(['--help']); "
        "print(sorted({'torch', 'numba', 'matplotlib', 'highway_env', 'cv2'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


@pytest.mark.parametrize(
    "command",
    [
        "generate",
        "benchmark",
        "evaluate",
        "report",
        "demo",
        "weathers",
        "scenarios",
        "suites",
        "play",
        "decimation",
        "events",
    ],
)
def test_each_command_explains_its_options(capsys, command):
    with pytest.raises(SystemExit) as stop:
        cli.main([command, "--help"])
    assert stop.value.code == 0
    assert f"pedcross {command}" in capsys.readouterr().out


def test_weathers_lists_the_bad_ones(capsys):
    assert cli.main(["weathers"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines if line.rstrip().endswith(" bad")] == ["rain", "storm", "fog"]


def test_suites_are_listed_with_where_they_come_from(capsys):
    assert cli.main(["suites"]) == 0
    printed = capsys.readouterr().out
    assert all(name in printed for name in SUITES)
    assert cli.main(["suites", "fmvss-127"]) == 0
    printed = capsys.readouterr().out
    assert "49 CFR 571.127" in printed
    assert "[memory]" in printed
    assert "FALSE-PLATE/80" in printed
    assert "Dark is an unlit night" in printed
    for cell in suite("fmvss-127").cells:
        assert cell.id in printed
    assert cli.main(["suites", "fmvs"]) == 2
    assert "'fmvss-127'" in capsys.readouterr().err

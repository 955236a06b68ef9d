"""The command line: each subcommand is one dataclass of settings and one function.

A subcommand's modules are imported only when it runs, so that ``pedcross --help`` answers at once.
"""

from __future__ import annotations

import contextlib
import io
import shlex
import sys
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from pedcross_env.errors import ConfigError, PedcrossError, unknown_name

if TYPE_CHECKING:
    from rich.console import Console

__all__ = ["COMMANDS", "main"]

T = TypeVar("T")
EXIT_ERROR, EXIT_INTERRUPTED = 2, 130


def main(argv: Sequence[str] | None = None) -> int:
    """Run a subcommand.

    Args:
        argv: Arguments without the program's name; default: the process's.

    Returns:
        0; 2 for an error a user can mend (its text goes to stderr); 130 when interrupted.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    if not arguments or arguments[0] in ("-h", "--help", "help"):
        print(_help())
        return 0
    if arguments[0] in ("-V", "--version"):
        from importlib.metadata import version

        print(f"pedcross {version('pedcross')}")
        return 0
    try:
        if arguments[0] not in COMMANDS:
            raise unknown_name("command", arguments[0], COMMANDS)
        from rich.console import Console

        COMMANDS[arguments[0]][1](arguments[1:], Console())
    except PedcrossError as error:
        print(f"error: {error}", file=sys.stderr)
        return EXIT_ERROR
    except OSError as error:
        print(f"error: {error.filename or 'input or output'}: {error.strerror or error}", file=sys.stderr)
        return EXIT_ERROR
    except KeyboardInterrupt:
        print("stopped; the same command goes on from what is finished.", file=sys.stderr)
        return EXIT_INTERRUPTED
    return 0


def _help() -> str:
    width = max(map(len, COMMANDS)) + 2
    lines = [f"  {name:<{width}}{text}" for name, (text, _) in COMMANDS.items()]
    return "\n".join(
        [
            "usage: pedcross COMMAND [OPTIONS]",
            "",
            "Score detectors of crossing pedestrians: offline on recorded clips, and braking in the loop.",
            "",
            *lines,
            "",
            "pedcross COMMAND --help lists a command's options; begin with pedcross demo.",
        ]
    )


def _parse(config: type[T], arguments: list[str], command: str) -> T:
    """Build ``config`` from arguments.

    For a wrong flag tyro prints what is wrong and exits with 2; where the config itself refuses a value, its
    own error is raised instead of tyro's box around it.
    """
    import tyro

    printed = io.StringIO()
    try:
        with contextlib.redirect_stderr(printed):
            return tyro.cli(
                config,
                args=arguments,
                prog=f"pedcross {command}",
                description=COMMANDS[command][0],
                config=(tyro.conf.AvoidSubcommands,),
            )
    except SystemExit as stop:
        cause: BaseException | None = stop
        while cause is not None and not isinstance(cause, PedcrossError):
            cause = cause.__context__
        if cause is not None:
            raise cause from None
        sys.stderr.write(printed.getvalue())
        raise


def _generate(arguments: list[str], console: Console) -> None:
    from eval.progress import bar
    from pedcross_env.recorder import GenerateConfig, generate

    config = _parse(GenerateConfig, arguments, "generate")
    with bar("recording videos", console) as progress:
        report = generate(config, progress)
    _say(
        console,
        f"{report.recorded} videos recorded, {report.already_there} were there: {report.frames} frames, "
        f"{report.positive_frames} of them with a crossing, in {report.root}",
    )


def _train(arguments: list[str], console: Console) -> None:
    from perception.training import TrainConfig, train

    config = _parse(TrainConfig, arguments, "train")
    result = train(config, command=shlex.join(["pedcross", "train", *arguments]), console=console)
    _say(console, f"checkpoint: {result.checkpoint}")


def _checkpoints(arguments: list[str], console: Console) -> None:
    from eval.checkpoints import CheckpointsConfig, make_checkpoints

    for result in make_checkpoints(_parse(CheckpointsConfig, arguments, "checkpoints"), console):
        _say(console, f"checkpoint: {result.checkpoint}")


def _benchmark(arguments: list[str], console: Console) -> None:
    from eval.offline import BenchmarkConfig, benchmark
    from eval.progress import bar
    from eval.report.format import interval, number

    config = _parse(BenchmarkConfig, arguments, "benchmark")
    with bar("scoring clips", console) as progress:
        report = benchmark(config, progress)
    rows = [
        (
            row["detector"],
            row["subset"],
            number(row["auroc"], 3),
            interval(row["auroc_low"], row["auroc_high"], 3),
            number(row["f_score"], 2),
            f"{row['positives']} of {row['clips']}",
            row["note"],
        )
        for row in report.table
    ]
    _table(console, ("detector", "subset", "AUROC", "95 %", "F-score", "positive clips", "note"), rows)


def _evaluate(arguments: list[str], console: Console) -> None:
    from eval.closed_loop import EvaluateConfig, evaluate
    from eval.demo import capture_for
    from eval.progress import bar
    from eval.report.format import percent_interval
    from eval.summary import summarise

    config = _parse(EvaluateConfig, arguments, "evaluate")
    with bar("driving episodes", console) as progress:
        report = evaluate(config, progress)
    if not config.suite:
        capture_for(config)
    if report.other_setups:
        _say(
            console,
            f"{report.other_setups} episodes in {config.out} are of another setup: left aside.",
        )
    if config.suite:
        _verdicts(report.rows, console)
        _rating(config.suite, report.rows, console)
        return
    rows = [
        (row["detector"], row["group"], f"{row['collisions']} of {row['crossings']}",
         percent_interval(row["collision_low"], row["collision_high"]),
         f"{row['false_braking']} of {row['free_episodes']}")
        for row in summarise(report.rows) if row["main"]
    ]  # fmt: skip
    _table(console, ("source", "weather", "collisions", "95 %", "brakes for nobody"), rows)


def _verdicts(rows: Sequence[dict[str, Any]], console: Console) -> None:
    """Print what the protocol says of each source's cells."""
    from eval.verdicts import by_scenario

    lines = [
        (row["detector"], row["scenario"], f"{row['passed']} of {row['episodes']}",
         f"{row['points']:g}" + (f" ({row['uncertain']} uncertain)" if row["uncertain"] else ""),
         f"{row['fastest_passed_kmh']:.0f}", f"{row['worst_impact_kmh']:.0f}" if row["worst_impact_kmh"] else "-")
        for row in by_scenario([row for row in rows if row["main"]])
    ]  # fmt: skip
    _table(
        console,
        ("source", "cells", "passed", "points", "all passed up to km/h", "worst impact km/h"),
        lines,
    )


def _rating(name: str, rows: Sequence[dict[str, Any]], console: Console) -> None:
    """Print what each source wins in the protocol's rating, of the groups of cells that were played wholly."""
    from eval.verdicts import rate
    from pedcross_env.scenario.suites import suite

    rated = rate(suite(name), [row for row in rows if row["main"]])
    for source in dict.fromkeys(row["detector"] for row in rated):
        own = [row for row in rated if row["detector"] == source]
        won, worth = (sum(row[key] for row in own) for key in ("points", "worth"))
        groups = ", ".join(f"{row['group']} {row['points']:.2f}" for row in own)
        _say(console, f"{source} wins {won:.2f} of {worth:g} points of the rating: {groups}")


def _report(arguments: list[str], console: Console) -> None:
    from eval.report import ReportConfig, build_report

    _say(console, f"report: {build_report(_parse(ReportConfig, arguments, 'report').out)}")


def _demo(arguments: list[str], console: Console) -> None:
    from eval.demo import DemoConfig, run_demo
    from eval.report.results import read_results
    from eval.report.words import summary_sentences

    report = run_demo(_parse(DemoConfig, arguments, "demo"), console)
    for sentence in summary_sentences(read_results(report.parent)):
        _say(console, f"- {sentence}")
    _say(console, f"report: {report}")


def _events(arguments: list[str], console: Console) -> None:
    from eval.progress import bar
    from eval.video_events import VideoEventsConfig, make_events

    # VIDEO may stand alone, as in `pedcross events drive.mp4`.
    if arguments and not arguments[0].startswith("-"):
        arguments = ["--video", *arguments]
    config = _parse(VideoEventsConfig, arguments, "events")
    with bar("making events", console) as progress:
        report = make_events(config, progress)
    height, width = report.shape
    rate = report.events / report.span_s / 1e6
    _say(
        console,
        f"{report.events:,} events ({report.on:,} ON) of {report.frames} frames, {width}x{height}, over "
        f"{report.span_s:.2f} s: {rate:.2f} million/s; the event camera took "
        f"{1e3 * report.camera_s / report.frames:.1f} ms of CPU per frame",
    )
    if report.source.count > 0 and config.duration_s is None and config.start_s == 0:
        missing = report.source.count - report.frames
        if missing > 0:
            _say(
                console,
                f"{missing} of {report.source.count} frames that the video announces could not be decoded.",
            )
    _say(console, f"events: {report.path}")
    if report.video is not None:
        _say(console, f"video: {report.video}")


def _play(arguments: list[str], console: Console) -> None:
    from eval.live import PlayConfig, play_live
    from eval.progress import bar

    config = _parse(PlayConfig, arguments, "play")
    with bar("playing", console) as progress:
        report = play_live(config, progress)
    end = report.trace.infos[-1]
    told = f" at {3.6 * end['impact_speed_mps']:.0f} km/h" if end["impact_speed_mps"] >= 0 else ""
    _say(console, f"{report.outcome}{told} after {end['time_s']:.2f} s")
    if report.path is not None:
        _say(console, f"video: {report.path}")


def _decimation(arguments: list[str], console: Console) -> None:
    from eval.decimation import DecimationConfig, run_decimation

    config = _parse(DecimationConfig, arguments, "decimation")
    original, losses = run_decimation(config)
    _say(
        console,
        f"{original.title}: {original.events.size} events on {original.picture.any(axis=2).sum()} pixels",
    )
    rows = [
        (loss.method, f"{100 * loss.kept:.1f}", f"{100 * loss.pedestrian_kept:.1f}", str(loss.active),
         f"{100 * loss.invalid:.1f}", f"{loss.strength:.2f}")
        for loss in losses
    ]  # fmt: skip
    _table(
        console, ("method", "kept %", "pedestrian kept %", "pixels", "no valid colour %", "strength"), rows
    )
    _say(console, f"figure: {config.out / 'decimation.png'}")


def _warmup(arguments: list[str], console: Console) -> None:
    _no_options(arguments, "warmup")
    from pedcross_env.warmup import compile_kernels

    _say(console, "compiling the kernels of camera, weather and sensors; once per installation ...")
    begin_s = time.perf_counter()
    compile_kernels()
    _say(console, f"ready after {time.perf_counter() - begin_s:.1f} s")


def _weathers(arguments: list[str], console: Console) -> None:
    _no_options(arguments, "weathers")
    from pedcross_env.weather import BAD_WEATHERS, weather_by_name, weather_names

    rows = []
    for name in weather_names():
        weather = weather_by_name(name)
        visibility = "" if weather.visibility_m == float("inf") else f"{weather.visibility_m:.0f}"
        group = "bad" if name in BAD_WEATHERS else ""
        sun = f"{weather.sun_altitude_deg:.0f}"
        rows.append((name, visibility, f"{weather.rain_mm_h:g}", sun, f"{weather.friction:.2f}", group))
    _table(console, ("weather", "visibility m", "rain mm/h", "sun deg", "friction", "group"), rows)


def _scenarios(arguments: list[str], console: Console) -> None:
    from eval.progress import bar
    from eval.scenario_statistics import PERCENTILES, ScenariosConfig, run_scenarios

    config = _parse(ScenariosConfig, arguments, "scenarios")
    with bar("driving", console) as progress:
        rows, figure = run_scenarios(config, progress)
    kept = 4 if config.jaad is not None else 3
    head = ("", "ours", "JAAD, all", "JAAD, here")[:kept]
    _table(console, head, [row[:kept] for row in rows])
    _say(console, f"three numbers: percentiles {', '.join(map(str, PERCENTILES))}; figure: {figure}")


def _suites(arguments: list[str], console: Console) -> None:
    from eval.suite_listing import print_suite, print_suites

    if arguments in (["-h"], ["--help"]):
        print(f"usage: pedcross suites [SUITE]\n\n{COMMANDS['suites'][0]}")
        raise SystemExit(0)
    if len(arguments) > 1:
        raise ConfigError(f"'pedcross suites' takes the name of one suite, but {arguments!r} were given.")
    if arguments:
        print_suite(arguments[0], console)
    else:
        print_suites(console)


def _no_options(arguments: list[str], command: str) -> None:
    if arguments in (["-h"], ["--help"]):
        print(f"usage: pedcross {command}\n\n{COMMANDS[command][0]}")
        raise SystemExit(0)
    if arguments:
        raise ConfigError(f"'pedcross {command}' takes no options, but {arguments[0]!r} was given.")


def _say(console: Console, text: str) -> None:
    console.print(text, highlight=False, markup=False, soft_wrap=True)


def _table(console: Console, head: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for i, name in enumerate(head):
        table.add_column(name, no_wrap=i == 0)
    for row in rows:
        table.add_row(*row)
    console.print(table)


COMMANDS: dict[str, tuple[str, Callable[[list[str], Any], None]]] = {
    "demo": ("the whole way once, small: record, score, drive, report", _demo),
    "generate": ("record labelled videos, RGB and events, in the paper's layout", _generate),
    "train": ("train a network on recorded videos and write a checkpoint", _train),
    "checkpoints": ("make the networks that are shipped: record, train, install", _checkpoints),
    "benchmark": ("score detectors on recorded videos: AUROC, F-score, intervals", _benchmark),
    "evaluate": ("let detectors brake on seeded crossings, beside the controls", _evaluate),
    "report": ("one HTML page of the results in a folder", _report),
    "events": ("a video to events, event frames and both side by side", _events),
    "play": ("watch one episode: both cameras, depth, the street from above, p(crossing)", _play),
    "decimation": (
        "what resizing does to event frames: the paper's appendix, drawn and counted",
        _decimation,
    ),
    "scenarios": ("measure random crossings, beside JAAD's: onsets, box heights, shares", _scenarios),
    "suites": ("list the suites of protocols, or with a name the cells of one", _suites),
    "weathers": ("list the weathers", _weathers),
    "warmup": ("compile the kernels now instead of at the first use", _warmup),
}
"""Name to what it does and the function that does it."""


if __name__ == "__main__":
    sys.exit(main())

"""The report's figures, as SVG text that needs no font and no network."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from eval.metrics import roc_points
from eval.report.results import SUBSET_GROUPS, Results
from eval.report.words import group_title

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["FIGURES"]

Row = dict[str, Any]
CONTROL_COLOUR = "#8a8f98"
MODALITY_MARKER = {"rgb": "o", "dvs": "s", "none": "D"}
PALETTE = ("#2563a8", "#c2571a", "#2e8540", "#8a3fa0", "#b0243c", "#0f7f86", "#8c6d1f", "#5a5f9e", "#d0679d")
WIDTH_IN = 6.6


def _figure(columns: int, height_in: float) -> tuple[Figure, list[Axes]]:
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH_IN, height_in), layout="constrained")
    FigureCanvasSVG(figure)
    axes = list(np.atleast_1d(figure.subplots(1, columns, sharey=True)))
    for axis in axes:
        axis.spines[["top", "right"]].set_visible(False)
        axis.tick_params(labelsize=9)
        axis.grid(color="#e6e8ec", linewidth=0.8)
        axis.set_axisbelow(True)
    return figure, axes


def _svg(figure: Figure) -> str:
    import matplotlib

    buffer = io.StringIO()
    # A fixed salt and no date: the same results give the same bytes.
    with matplotlib.rc_context({"svg.hashsalt": "pedcross", "svg.fonttype": "path"}):
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    return buffer.getvalue()


def _colours(results: Results) -> dict[str, str]:
    names = sorted({row["detector"] for row in results.closed_loop if row["kind"] == "detector"} |
                   {row["detector"] for row in results.offline})  # fmt: skip
    return {name: PALETTE[i % len(PALETTE)] for i, name in enumerate(names)}


def _colour(colours: dict[str, str], row: Row) -> str:
    return CONTROL_COLOUR if row.get("kind") == "control" else colours[row["detector"]]


def _order(results: Results) -> list[str]:
    """Sources from most to fewest collisions over all groups; controls on top of the figure."""
    total: dict[str, float] = {}
    kind = {}
    for row in results.closed_loop:
        if row["main"]:
            rate = 0.0 if math.isnan(row["collision_rate"]) else row["collision_rate"]
            total[row["detector"]] = total.get(row["detector"], 0.0) + rate
            kind[row["detector"]] = row["kind"]
    return sorted(total, key=lambda name: (kind[name] == "control", total[name], name), reverse=True)


def collision_rates(results: Results) -> str | None:
    """Collision rate per source with Wilson intervals, one panel per group."""
    groups = [group for group in results.groups() if results.main(group)[0]["crossings"]]
    if not groups:
        return None
    names, colours = _order(results), _colours(results)
    figure, axes = _figure(len(groups), 0.9 + 0.3 * len(names))
    for axis, group in zip(axes, groups, strict=True):
        rows = {row["detector"]: row for row in results.main(group)}
        for y, name in enumerate(reversed(names)):
            if name not in rows:
                continue
            row = rows[name]
            rate, colour = 100 * row["collision_rate"], _colour(colours, row)
            axis.barh(y, rate, height=0.62, color=colour, alpha=0.35)
            axis.plot(
                [100 * row["collision_low"], 100 * row["collision_high"]], [y, y], color=colour, linewidth=2
            )
            axis.plot(rate, y, MODALITY_MARKER[row["modality"]], color=colour, markersize=5)
        axis.set_xlim(-2, 102)
        axis.set_title(f"{group_title(group)} (n = {rows[names[0]]['crossings']})", fontsize=10, loc="left")
        axis.set_xlabel("collisions, % of crossings", fontsize=9)
        axis.set_yticks(range(len(names)), list(reversed(names)))
        axis.grid(axis="y", visible=False)
    return _svg(figure)


def impact_speeds(results: Results) -> str | None:
    """Every collision's impact speed, and the median."""
    hits = [row for row in results.episodes if row["main"] and row["is_crossing"] and row["collision"]]
    if not hits:
        return None
    from eval.summary import group_of

    names, colours = _order(results), _colours(results)
    groups = [group for group in results.groups() if any(group_of(row["weather"]) == group for row in hits)]
    figure, axes = _figure(len(groups), 0.9 + 0.3 * len(names))
    jitter = np.random.default_rng(0)
    for axis, group in zip(axes, groups, strict=True):
        for y, name in enumerate(reversed(names)):
            own = [row for row in hits if row["detector"] == name and group_of(row["weather"]) == group]
            speeds = 3.6 * np.array([row["impact_speed_mps"] for row in own])
            if not speeds.size:
                continue
            colour = _colour(colours, own[0])
            heights = y + jitter.uniform(-0.22, 0.22, speeds.size)
            axis.plot(speeds, heights, "o", color=colour, alpha=0.45, markersize=4, markeredgewidth=0)
            axis.plot([np.median(speeds)] * 2, [y - 0.32, y + 0.32], color=colour, linewidth=2.2)
        axis.set_title(group_title(group), fontsize=10, loc="left")
        axis.set_xlabel("impact speed, km/h", fontsize=9)
        axis.set_xlim(0, 1.05 * max(3.6 * row["impact_speed_mps"] for row in hits))
        axis.set_ylim(-0.6, len(names) - 0.4)
        axis.set_yticks(range(len(names)), list(reversed(names)))
        axis.grid(axis="y", visible=False)
    return _svg(figure)


def auroc_against_collisions(results: Results) -> str | None:
    """Offline AUROC against the collision rate, with both intervals; oracle and never as lines."""
    colours = _colours(results)
    panels = []
    for subset, group in SUBSET_GROUPS.items():
        risk = {r["detector"]: r for r in results.main(group) if r["crossings"]}
        scored = [r for r in results.offline if r["subset"] == subset and not math.isnan(r["auroc"])]
        both = [(r, risk[r["detector"]]) for r in scored if r["detector"] in risk]
        if both:
            panels.append((group, both, risk))
    if not panels:
        return None
    figure, axes = _figure(len(panels), 3.5)
    seen: dict[str, Any] = {}
    for axis, (group, both, risk) in zip(axes, panels, strict=True):
        for name, style in (("never", "--"), ("oracle", ":")):
            if name in risk:
                rate = 100 * risk[name]["collision_rate"]
                axis.axhline(rate, color=CONTROL_COLOUR, linestyle=style, linewidth=1.2)
                _note(axis, name, (1, rate), (-2, 2), "right", xycoords=("axes fraction", "data"))
        for i, (score, row) in enumerate(both):
            size = max(5.0, 10.0 - 0.7 * i)  # the later the smaller: equal points stay visible
            colour, rate = colours[row["detector"]], 100 * row["collision_rate"]
            axis.plot([score["auroc_low"], score["auroc_high"]], [rate, rate], color=colour, alpha=0.5)
            axis.plot([score["auroc"]] * 2, [100 * row["collision_low"], 100 * row["collision_high"]],
                      color=colour, alpha=0.5)  # fmt: skip
            marker = MODALITY_MARKER[row["modality"]]
            marks = axis.plot(score["auroc"], rate, marker, color=colour, markersize=size, linestyle="")
            seen[row["detector"]] = marks[0]
        axis.set_title(group_title(group), fontsize=10, loc="left")
        axis.set_xlabel("offline AUROC", fontsize=9)
        axis.set_ylim(-3, 103)
    axes[0].set_ylabel("collisions, % of crossings", fontsize=9)
    _legend(figure, seen)
    return _svg(figure)


def collisions_against_false_braking(results: Results) -> str | None:
    """Operating points: what fewer collisions cost in braking for nobody."""
    usable = [r for r in results.closed_loop if r["crossings"] and r["free_episodes"]]
    groups = [group for group in results.groups() if any(r["group"] == group for r in usable)]
    if not groups:
        return None
    colours = _colours(results)
    figure, axes = _figure(len(groups), 3.5)
    seen: dict[str, Any] = {}
    for axis, group in zip(axes, groups, strict=True):
        rows = [r for r in usable if r["group"] == group]
        controls: dict[tuple[float, float], list[str]] = {}  # those at one point share a label
        for i, name in enumerate(dict.fromkeys(r["detector"] for r in rows)):
            size = max(4.0, 14.0 - 1.2 * i)  # the later the smaller: equal points stay visible
            own = sorted((r for r in rows if r["detector"] == name), key=lambda r: r["threshold"])
            x, y = ([100 * r[key] for r in own] for key in ("false_rate", "collision_rate"))
            colour = _colour(colours, own[0])
            if len(own) > 1:
                axis.plot(x, y, color=colour, alpha=0.6, linewidth=1.2)
                axis.plot(x, y, ".", color=colour, markersize=5)
            main = [(a, b) for a, b, r in zip(x, y, own, strict=True) if r["main"]]
            marks = axis.plot(*zip(*main, strict=True), MODALITY_MARKER[own[0]["modality"]], color=colour,
                              markersize=size, markeredgecolor="white", linestyle="")  # fmt: skip
            if own[0]["kind"] == "control":
                controls.setdefault(main[0], []).append(name)
            else:
                seen[name] = marks[0]
        for point, names in controls.items():
            right = point[0] > 60
            _note(axis, ", ".join(names), point, (-6 if right else 6, 5), "right" if right else "left")
        axis.set_title(group_title(group), fontsize=10, loc="left")
        axis.set_xlabel("braking for nobody,\n% of drives without a crossing", fontsize=9)
        axis.set_xlim(-4, 104)
        axis.set_ylim(-4, 112)
    axes[0].set_ylabel("collisions, % of crossings", fontsize=9)
    _legend(figure, seen)
    return _svg(figure)


def roc_curves(results: Results) -> str | None:
    """ROC per subset, the checkpoint's threshold marked."""
    subsets = sorted({row["subset"] for row in results.offline if not math.isnan(row["auroc"])})
    if not subsets:
        return None
    colours = _colours(results)
    figure, axes = _figure(len(subsets), 3.6)
    seen: dict[str, Any] = {}
    for axis, subset in zip(axes, subsets, strict=True):
        axis.plot([0, 1], [0, 1], color="#b9bec6", linewidth=1, linestyle=":")
        for row in (r for r in results.offline if r["subset"] == subset and not math.isnan(r["auroc"])):
            name = row["detector"]
            own = [clip for clip in results.clips if (clip["detector"], clip["subset"]) == (name, subset)]
            labels, p = np.array([c["label"] for c in own]), np.array([c["p"] for c in own])
            false, true, _ = roc_points(labels, p)
            style = "-" if row["modality"] == "rgb" else (0, (4, 1.5))
            seen[name] = axis.plot(false, true, color=colours[name], linestyle=style, linewidth=1.6)[0]
            alarm = p >= row["threshold"]
            axis.plot(alarm[labels == 0].mean(), alarm[labels == 1].mean(), MODALITY_MARKER[row["modality"]],
                      color=colours[name], markersize=6)  # fmt: skip
        axis.set_title(f"subset “{subset}”", fontsize=10, loc="left")
        axis.set_xlabel("false positive rate", fontsize=9)
        axis.set_aspect("equal")
    axes[0].set_ylabel("true positive rate", fontsize=9)
    _legend(figure, seen)
    return _svg(figure)


def _note(
    axis: Axes,
    text: str,
    at: tuple[float, float],
    offset: tuple[int, int],
    align: str,
    *,
    xycoords: Any = "data",
) -> None:
    axis.annotate(
        text, at, xycoords=xycoords, xytext=offset, textcoords="offset points", ha=align, fontsize=8,
        color="#5b6068",
    )  # fmt: skip


def _legend(figure: Figure, handles: dict[str, Any]) -> None:
    if handles:
        names: Sequence[str] = sorted(handles)
        figure.legend([handles[name] for name in names], names, loc="outside lower center",
                      ncols=min(3, len(names)), fontsize=8.5, frameon=False)  # fmt: skip


FIGURES: dict[str, Callable[[Results], str | None]] = {
    "collision_rates": collision_rates,
    "impact_speeds": impact_speeds,
    "auroc_against_collisions": auroc_against_collisions,
    "collisions_against_false_braking": collisions_against_false_braking,
    "roc_curves": roc_curves,
}
"""Name in the template to the function that draws it; None where there is nothing to draw."""

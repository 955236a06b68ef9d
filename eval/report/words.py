"""The summary in words, computed from the rows; it claims no more than the intervals carry."""

from __future__ import annotations

import math
from typing import Any

from eval.report.format import interval, kmh, percent, percent_interval
from eval.report.results import SUBSET_GROUPS, Results

__all__ = ["choice_of_crossings", "group_title", "played_seeds", "summary_sentences", "warnings"]

Row = dict[str, Any]
FEW_CROSSINGS = 30
FEW_VIDEOS = 20


def group_title(group: str) -> str:
    """Return how the report calls a weather group."""
    return {"clear": "clear weather", "bad": "bad weather"}.get(group, group.replace("_", " "))


def summary_sentences(results: Results) -> list[str]:
    """Return the findings, the most important first."""
    sentences = [sentence for group in results.groups() for sentence in _loop_sentences(results, group)]
    sentences += [
        _offline_sentence(results, subset) for subset in sorted({r["subset"] for r in results.offline})
    ]
    sentences += [_kept_apart_sentence(results), *_link_sentences(results)]
    return [sentence for sentence in sentences if sentence]


def played_seeds(results: Results) -> str:
    """Return which seeds were driven: a range, or the list where some were passed over."""
    seeds = (results.evaluate or {}).get("seeds", [])
    if not seeds:
        return ""
    if len(seeds) == seeds[-1] - seeds[0] + 1:
        return f"seeds {seeds[0]} to {seeds[-1]}"
    return f"seeds {', '.join(map(str, seeds))}"


def choice_of_crossings(results: Results) -> str:
    """Return the sentence on how episodes were chosen; empty where every seed was played."""
    if ((results.evaluate or {}).get("settings") or {}).get("hit_share") is None:
        return ""
    return (
        "Only such crossings were chosen as hit a car that never brakes, before any detector saw them: "
        "on those that miss it anyway every detector scores alike."
    )


def _loop_sentences(results: Results, group: str) -> list[str]:
    rows = {row["detector"]: row for row in results.main(group)}
    detectors = [row for row in rows.values() if row["kind"] == "detector" and row["crossings"]]
    where = group_title(group).capitalize()
    sentences = []
    never, oracle = rows.get("never"), rows.get("oracle")
    if never is not None and never["crossings"]:
        text = f"{where}: without braking, {never['collisions']} of {never['crossings']} crossings end in a "
        text += "collision"
        if oracle is not None:
            text += f"; braking on the true label leaves {oracle['collisions']}"
        sentences.append(text + ".")
    if not detectors:
        return sentences
    best = min(detectors, key=lambda r: (r["collision_rate"], _or_inf(r["false_rate"]), r["detector"]))
    if never is not None and best["collisions"] >= never["collisions"] > 0:
        sentences.append(f"{where}: no detector has fewer collisions than a car that never brakes.")
        return sentences + _timid_sentences(where, detectors)
    bounds = percent_interval(best["collision_low"], best["collision_high"])
    text = (
        f"{where}: the fewest collisions has {best['detector']}, {best['collisions']} of {best['crossings']} "
        f"({percent(best['collision_rate'])}, 95 % interval {bounds} %)"
    )
    if best["collisions"]:
        text += f", at {kmh(best['impact_mean_mps'])} km/h on average"
    text += _price(best)
    equal = [r["detector"] for r in detectors if r is not best and r["collisions"] == best["collisions"]]
    if equal:
        text += f" As few have {', '.join(equal)}."
    sentences.append(text)
    return sentences + _timid_sentences(where, detectors)


def _timid_sentences(where: str, detectors: list[Row]) -> list[str]:
    timid = [r for r in detectors if r["free_episodes"] and r["false_rate"] >= 0.5]
    if not timid:
        return []
    names = ", ".join(f"{r['detector']} ({r['false_braking']} of {r['free_episodes']})" for r in timid)
    return [
        f"{where}: these brake for nobody in at least half of the drives without a crossing, so "
        f"that few collisions say little: {names}."
    ]


def _price(row: Row) -> str:
    if not row["free_episodes"]:
        return "; no drive without a crossing was played, so its false braking is unknown."
    share = f"{row['false_braking']} of {row['free_episodes']}"
    return f"; it brakes for nobody in {share} drives without a crossing."


def _offline_sentence(results: Results, subset: str) -> str:
    rows = [row for row in results.offline if row["subset"] == subset]
    scored = [row for row in rows if not math.isnan(row["auroc"])]
    if not scored:
        return f"Offline, subset “{subset}”: no AUROC can be given ({rows[0]['note']})."
    best = max(scored, key=lambda row: row["auroc"])
    bounds = interval(best["auroc_low"], best["auroc_high"])
    text = f"Offline, subset “{subset}”: the highest AUROC has {best['detector']}, {best['auroc']:.3f}"
    text += f" (95 % {bounds} over {best['videos']} videos)." if bounds else f" ({best['note']})."
    inside = [r["detector"] for r in scored if r is not best and bounds and r["auroc"] >= best["auroc_low"]]
    if inside:
        text += f" Within its interval lie {', '.join(inside)}."
    return text


def _kept_apart_sentence(results: Results) -> str:
    """How good the networks are on more videos than a small run records."""
    scores = {
        name: (about["metrics"]["test_auroc"], len(detector["test_videos"]))
        for name, detector in results.detectors().items()
        if (about := detector["about"]).get("metrics") and detector.get("test_videos")
    }
    known = {name: score for name, score in scores.items() if not math.isnan(score[0])}
    if not known:
        return ""
    best = max(known, key=lambda name: known[name][0])
    videos = sorted({videos for _, videos in known.values()})
    text = f"On the {' or '.join(map(str, videos))} videos that its own training kept apart, "
    if len(known) == 1:
        return text + f"{best} has an AUROC of {known[best][0]:.3f}."
    least = min(score for score, _ in known.values())
    return text + f"each network has an AUROC of {least:.3f} to {known[best][0]:.3f}, the highest {best}."


def _link_sentences(results: Results) -> list[str]:
    sentences = []
    for subset, group in SUBSET_GROUPS.items():
        risk = {r["detector"]: r for r in results.main(group) if r["kind"] == "detector" and r["crossings"]}
        both = [
            r
            for r in results.offline
            if r["subset"] == subset and r["detector"] in risk and not math.isnan(r["auroc"])
        ]
        if len(both) < 2:
            continue
        chosen = max(both, key=lambda r: r["auroc"])["detector"]
        least = min(risk[r["detector"]]["collision_rate"] for r in both)
        regret = risk[chosen]["collision_rate"] - least
        text = f"Choosing by AUROC in {group_title(group)} picks {chosen}, which "
        if regret == 0:
            text += "is also among those with the fewest collisions"
        else:
            own = percent(risk[chosen]["collision_rate"])
            text += f"collides in {own} of the crossings; the best in {percent(least)}"
        sentences.append(text + f" ({len(both)} detectors: too few for a rank correlation).")
    return sentences


def warnings(results: Results) -> list[str]:
    """Return what a reader must know before quoting a number."""
    found = []
    seen = (results.benchmark or {}).get("trained_on_this_data", [])
    if seen:
        found.append(
            f"The offline scores of {', '.join(seen)} are no test: most of these videos were used in "
            "training. Use --split test or other videos."
        )
    for group in results.groups():
        crossings = results.main(group)[0]["crossings"]
        if crossings < FEW_CROSSINGS:
            found.append(
                f"Only {crossings} crossing episodes in {group_title(group)}: differences of a few "
                "collisions are noise. More with --episodes."
            )
    videos = [(row["subset"], row["videos"]) for row in results.offline]
    for subset, number in sorted(set(videos)):
        if number < FEW_VIDEOS:
            found.append(f"Only {number} videos in subset “{subset}”: intervals over so few are rough.")
    for row in results.offline:
        if row["note"]:
            found.append(f"{row['detector']} on “{row['subset']}”: {row['note']}.")
    return found


def _or_inf(value: float) -> float:
    return math.inf if math.isnan(value) else value

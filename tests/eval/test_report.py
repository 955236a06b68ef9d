import dataclasses
import re
import shutil
from html.parser import HTMLParser

import cv2
import numpy as np
import pytest
import test_closed_loop
import test_offline
from fake_world import FakeDetector

from eval.offline import BenchmarkConfig, benchmark
from eval.report import build_report
from eval.report.figures import FIGURES
from eval.report.format import interval, kmh, number, p_value, percent
from eval.report.paper import paper_energy, paper_score
from eval.report.results import read_results
from eval.report.words import choice_of_crossings, played_seeds, summary_sentences, warnings
from eval.store import write_json, write_rows
from pedcross_env.errors import DataError

NAMES = ("sharp", "blind", "jumpy")


class Page(HTMLParser):
    """Collects what a browser would load, the tags left open, and the text."""

    def __init__(self, text):
        super().__init__()
        self.sources, self.open, self.text = [], [], ""
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.sources += [value for key, value in attributes if key in ("src", "href", "srcset", "data")]
        if tag not in ("meta", "img", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


def spec(name):
    about = {
        "model": "pt_resnet18",
        "frames": 9,
        "fingerprint": "0123456789",
        "command": "pedcross train",
        "seed": 3,
    }
    return dataclasses.replace(test_closed_loop.spec(name), about=about)


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """A small benchmark and evaluation by fakes, one subset of one class only, with sample frames."""
    root = tmp_path_factory.mktemp("results")
    rng = np.random.default_rng(0)
    for i in range(6):
        labels = [0] * 6 + [1] * 5 * (i % 2)
        values = [
            int(v) + 60 * label for v, label in zip(rng.integers(0, 150, len(labels)), labels, strict=True)
        ]
        test_offline.write_video(root / "data", f"video_{i}", labels, values)
        test_offline.write_video(root / "data", f"video_{i}", [0] * 6, values[:6], subset="weather")
    out = root / "out"
    specs = [spec(name) for name in NAMES]
    benchmark(BenchmarkConfig(data=root / "data", out=out, stride=1), specs=specs, loader=FakeDetector)
    test_closed_loop.run(out, specs=specs, weathers=("clear", "rain"), episodes=6, extra_thresholds=(0.9,))
    (out / "samples").mkdir()
    for kind in ("rgb", "dvs"):
        cv2.imwrite(str(out / "samples" / f"clear_{kind}.png"), np.zeros((8, 8, 3), np.uint8))
    facts = {"weather": "clear", "seed": 0, "time_s": 1.0, "distance_m": 12.0, "speed_mps": 10.0}
    write_json(out / "samples" / "samples.json", [facts, facts | {"weather": "lost"}])
    return out


@pytest.fixture(scope="module")
def page(results):
    return Page(build_report(results).read_text(encoding="utf-8"))


def test_the_page_is_whole_and_loads_nothing_from_elsewhere(results, page):
    assert page.open == []
    assert len(page.sources) == len(FIGURES) + 2
    assert all(source.startswith("data:image/") for source in page.sources)
    raw = (results / "report.html").read_text(encoding="utf-8")
    assert not re.search(r"https?://|@import|url\(|<script|<link", raw)


def test_the_page_shows_every_source_and_what_it_was_made_with(page):
    for word in (
        *NAMES,
        "oracle",
        "never",
        "always",
        "random",
        "pedcross train",
        "0123456789",
        "Wilson",
        "numpy",
    ):
        assert word in page.text, word


def test_the_same_results_give_the_same_page(results):
    assert build_report(results).read_bytes() == build_report(results).read_bytes()


def test_a_score_that_cannot_be_given_is_a_dash_with_its_reason_and_never_a_zero(page):
    weather = page.text[page.text.index("subset “weather”", page.text.index("recorded clips")) :]
    cells = weather[: weather.index("A clip is positive")]
    assert "–" in cells
    assert "0.000" not in cells
    assert "one class only: all 24 clips are negative" in cells


def test_the_papers_numbers_stand_beside_ours_with_a_warning(page):
    assert "0.952 / 77 %" in page.text
    assert "a difference is no finding" in page.text


def test_words_follow_from_the_rows(results):
    text = " ".join(summary_sentences(read_results(results)))
    assert "Clear weather: without braking, 3 of 3 crossings end in a collision" in text
    assert "braking on the true label leaves 0" in text
    assert "the fewest collisions has sharp, 0 of 3 (0 %" in text
    assert "jumpy (3 of 3)" in text


def test_the_networks_scores_on_their_own_test_videos_are_told(results):
    read = read_results(results)
    assert not any("kept apart" in sentence for sentence in summary_sentences(read))
    scores = {"sharp": 0.812, "blind": 0.503, "jumpy": float("nan")}
    for detector in read.evaluate["detectors"] + read.benchmark["detectors"]:
        detector["about"]["metrics"] = {"test_auroc": scores[detector["name"]]}
        detector["test_videos"] = ["default/video_0", "default/video_1"]
    told = [sentence for sentence in summary_sentences(read) if "kept apart" in sentence]
    assert told == [
        "On the 2 videos that its own training kept apart, each network has an AUROC of 0.503 to 0.812, the "
        "highest sharp."
    ]


def test_no_detector_is_praised_for_as_many_collisions_as_never(results):
    read = read_results(results)
    told = summary_sentences(read)
    assert "Bad weather: no detector has fewer collisions than a car that never brakes." in told
    assert not any(s.startswith("Bad weather: the fewest collisions") for s in told)
    assert any(s.startswith("Clear weather: the fewest collisions has sharp") for s in told)


def test_where_detectors_see_is_shown_where_it_is_known(results, page, tmp_path):
    assert "Where they see" not in page.text
    whole = shutil.copytree(results, tmp_path / "whole")
    score = {"clips": 9, "positives": 4, "auroc": 0.66, "auroc_low": 0.5, "auroc_high": 0.8}
    empty = {
        "clips": 0,
        "positives": 0,
        "auroc": float("nan"),
        "auroc_low": float("nan"),
        "auroc_high": float("nan"),
    }
    write_rows(
        whole / "strata.parquet",
        [
            {"detector": "sharp", "by": "speed_mps", "from": 4.0, "to": 8.0, **score},
            {"detector": "sharp", "by": "distance_m", "from": 32.0, "to": float("inf"), **empty},
        ],
    )
    text = Page(build_report(whole).read_text()).text
    assert "Where they see" in text
    assert "14 to 29 km/h" in text
    assert "0.66[0.50, 0.80] 4" in text
    assert "from 32 m" in text


def test_a_choice_of_crossings_is_told(results):
    read = read_results(results)
    assert played_seeds(read) == "seeds 0 to 5"
    assert choice_of_crossings(read) == ""
    read.evaluate["settings"]["hit_share"], read.evaluate["seeds"] = 0.75, [0, 1, 4]
    assert played_seeds(read) == "seeds 0, 1, 4"
    assert "hit a car that never brakes" in choice_of_crossings(read)


def test_small_samples_are_warned_of(results):
    text = " ".join(warnings(read_results(results)))
    assert "Only 3 crossing episodes in clear weather" in text
    assert "Only 6 videos" in text


def test_a_part_that_was_not_run_is_named_not_invented(tmp_path):
    test_closed_loop.run(tmp_path, episodes=2)
    text = Page(build_report(tmp_path).read_text(encoding="utf-8")).text
    assert "Not run. pedcross benchmark" in text


def test_an_empty_folder_is_an_error(tmp_path):
    with pytest.raises(DataError, match="holds no results"):
        build_report(tmp_path)


def test_nan_is_a_dash_in_every_format():
    nan = float("nan")
    assert [number(nan), percent(nan), kmh(nan), p_value(nan), interval(nan, nan)] == ["–"] * 4 + [""]
    assert [number(0.0), percent(0.0), kmh(10.0), p_value(1e-5)] == ["0.00", "0 %", "36", "< 0.001"]


def test_the_papers_tables_are_copied_right():
    assert paper_score("sps_r18t", 30, "weather", "dvs") == (0.9542, 75.5)
    assert paper_score("stacked_resnet18", 9, "weather", "dvs") is None
    assert paper_energy("pt_resnet18", 9) == 166.33

import math

import cv2
import numpy as np
import pytest

from eval import canvas
from eval.canvas import StoppedByUser, VideoFile, Window, blank, fit, open_screen, text
from eval.dashboard import SIZE, Scene, draw_dashboard
from eval.live import PlayConfig, play_live
from pedcross_env.config import TrafficConfig
from pedcross_env.errors import ConfigError

SHORT = TrafficConfig(duration_s=1.0)


def frames_of(path):
    video, frames = cv2.VideoCapture(str(path)), []
    while True:
        ok, frame = video.read()
        if not ok:
            return frames
        frames.append(frame[..., ::-1])


def info(**changes):
    return {
        "time_s": 0.0, "crossing": 0, "visible_fraction": -1.0, "ttc_s": math.inf, "distance_m": math.inf,
        "speed_mps": 10.0, "acceleration_mps2": 0.0, "demand_mps2": 0.0, "impact_speed_mps": -1.0,
        "outcome": "running",
    } | changes  # fmt: skip


def scene(**changes):
    rng = np.random.default_rng(0)
    parts = {
        "rgb": rng.integers(0, 255, (54, 96, 3), np.uint8), "dvs": np.zeros((54, 96, 2), np.uint8),
        "depth": np.full((54, 96), 10.0), "above": np.zeros((480, 190, 3), np.uint8), "boxes": [],
        "title": "test", "threshold": 0.5, "duration_s": 10.0,
    }  # fmt: skip
    return Scene(**parts | changes)


def differs(one, other, box):
    x, y, width, height = box
    part = slice(y, y + height), slice(x, x + width)
    return bool((one[part] != other[part]).any())


def test_an_episode_becomes_a_video_of_every_step_and_the_outcome_held(tmp_path):
    seen = []
    config = PlayConfig(out=tmp_path / "a.mp4", camera="compact", traffic=SHORT, weather="fog")
    report = play_live(config, lambda *progress: seen.append(progress))
    frames = frames_of(report.path)
    assert len(frames) == len(report.trace.infos) + math.ceil(1.5 * 30)
    assert frames[0].shape == (SIZE[1], SIZE[0], 3)
    assert seen[-1][:2] == (30, 30)
    assert report.outcome == report.trace.infos[-1]["outcome"] != "running"
    assert [path.name for path in tmp_path.iterdir()] == ["a.mp4"]
    moved = np.abs(frames[0][72:363, 12:524].astype(int) - frames[20][72:363, 12:524]).mean()
    assert moved > 1  # the camera's view is alive


def test_a_suites_cell_is_played_in_its_own_weather(tmp_path, monkeypatch):
    titles = []

    def draw(scene, infos, probabilities):
        if len(infos) > 2:
            raise StoppedByUser
        titles.append(scene.title)
        return blank(64, 48)

    monkeypatch.setattr("eval.live.draw_dashboard", draw)
    config = PlayConfig(
        out=tmp_path / "a.avi", camera="compact", suite="fmvss-127", cell="PED-RIGHT-50/40", driver="always"
    )
    report = play_live(config)
    assert report.trace.infos[0]["scenario"] == "PED-RIGHT-50/40"
    assert titles[0].startswith("always drives   ·   fmvss-127 PED-RIGHT-50/40")
    assert titles[0].endswith(report.trace.infos[0]["weather"])


def test_the_dashboard_shows_what_the_episode_does():
    plain = draw_dashboard(scene(), [info()], [])
    assert plain.shape == (SIZE[1], SIZE[0], 3)
    tiles, plot, views = (536, 585, 512, 103), (536, 397, 512, 176), (12, 72, 1036, 291)
    for change in (
        {"speed_mps": 3.0}, {"acceleration_mps2": -8.0}, {"ttc_s": 1.2}, {"crossing": 1, "distance_m": 9.0},
    ):  # fmt: skip
        assert differs(plain, draw_dashboard(scene(), [info(**change)], []), tiles), change
    later = [info(), info(time_s=1.0, demand_mps2=-9.0)]
    assert differs(plain, draw_dashboard(scene(), later, [0.9]), plot)
    boxed = draw_dashboard(scene(boxes=[((10.0, 10.0, 20.0, 40.0), True)]), [info()], [])
    assert differs(plain, boxed, views)
    for outcome in ("collision", "passed", "timeout"):
        assert differs(
            plain, draw_dashboard(scene(), [info(outcome=outcome, impact_speed_mps=5.0)], []), views
        )


def test_a_p_that_is_not_there_yet_is_no_line_at_zero():
    moments = [info(), info(time_s=1.0), info(time_s=2.0)]
    unknown = draw_dashboard(scene(), moments, [math.nan, math.nan])
    zero = draw_dashboard(scene(), moments, [0.0, 0.0])
    assert differs(unknown, zero, (536, 397, 512, 176))


def test_cameras_of_any_shape_are_fitted_without_distortion():
    board = blank(200, 100)
    x, y, scale = fit(board, np.full((10, 40, 3), 255, np.uint8), (0, 0, 200, 100))
    assert (x, y, scale) == (0, 25, 5)
    assert (board == 255).all(axis=2).sum() == 200 * 50


def test_text_beyond_the_canvas_is_cut_off():
    board = blank(40, 20)
    text(board, "far too long for this", (-30, -5))
    text(board, "outside", (100, 100))
    assert (board != canvas.BACKGROUND).any()


def test_an_error_leaves_no_video_and_an_interrupt_leaves_what_there_is(tmp_path):
    path = tmp_path / "a.avi"

    def film(then):
        with open_screen(path, 30) as screen:
            screen.show(blank(64, 48))
            raise then

    with pytest.raises(ZeroDivisionError):
        film(ZeroDivisionError())
    assert not list(tmp_path.iterdir())
    with pytest.raises(KeyboardInterrupt):
        film(KeyboardInterrupt())
    assert len(frames_of(path)) == 1


def test_a_window_shows_and_closes_where_there_is_a_display(monkeypatch):
    pygame = pytest.importorskip("pygame")
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    config = PlayConfig(window=True, camera="compact", traffic=SHORT, slow_motion=0.05)
    original = Window.show
    shown = []

    def show(self, picture):
        shown.append(picture)
        if len(shown) == 3:
            pygame.event.post(pygame.event.Event(pygame.QUIT))
        original(self, picture)

    monkeypatch.setattr(Window, "show", show)
    report = play_live(config)
    assert (len(shown), report.outcome, report.path) == (3, "running", None)
    assert len(report.trace.infos) == 3


def test_mistakes_name_the_remedy(tmp_path, monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(canvas.sys, "platform", "linux")
    with pytest.raises(ConfigError, match="leave out --window"):
        Window("test", 30)
    with pytest.raises(ConfigError, match=r"\.mp4 or \.avi"):
        VideoFile(tmp_path / "a.gif", 30)
    with pytest.raises(ConfigError, match="Did you mean 'rain'"):
        PlayConfig(weather="rane")
    with pytest.raises(ConfigError, match="Did you mean 'oracle'"):
        play_live(PlayConfig(driver="oracel", out=tmp_path / "a.mp4"))
    with pytest.raises(ConfigError, match="left out for a suite"):
        PlayConfig(suite="un-r152", weather="fog")
    with pytest.raises(ConfigError, match="cell = '' is not allowed"):
        PlayConfig(suite="un-r152")
    with pytest.raises(
        ConfigError, match="cell = 'CPNCO-50/40' is not allowed: it must be given with a suite"
    ):
        PlayConfig(cell="CPNCO-50/40")
    with pytest.raises(ConfigError, match="slow_motion = 0"):
        PlayConfig(slow_motion=0)

"""Hedges between houses: leaves that fill the gap and stay in it."""

import numpy as np
import pytest
from camera_scenes import renderer, snapshot

from pedcross_env.camera import camera_pose, project
from pedcross_env.camera.scenery import scenery_of
from pedcross_env.camera.scenery.buildings import Hedge, building_rows
from pedcross_env.contracts import StaticClass
from pedcross_env.scenario.street import StreetSpec
from pedcross_env.weather import Weather


def hedges_of(street: StreetSpec) -> list[Hedge]:
    """As ``scenery_of`` draws them."""
    return building_rows(street, np.random.default_rng([street.seed, 11]).spawn(2)[0]).hedges


@pytest.fixture(scope="module")
def street() -> StreetSpec:
    """One with a hedge on the right, where the camera can see it."""
    streets = (StreetSpec(seed=seed) for seed in range(60))
    return next(s for s in streets if any(h.y < 0 and 20 < h.x0 < s.end_x_m - 30 for h in hedges_of(s)))


def test_bushes_fill_their_gap(street: StreetSpec) -> None:
    groups = scenery_of(street).groups
    for hedge in hedges_of(street):
        mine = groups[
            (np.abs(groups[:, 9] - hedge.y) < 0.06) & (groups[:, 8] > hedge.x0) & (groups[:, 8] < hedge.x1)
        ]
        half, top = np.abs(mine[:, 11]), mine[:, 10] + mine[:, 12]
        assert (mine[:, 6] == StaticClass.VEGETATION).all()
        assert 0.2 < hedge.x0 - (mine[:, 8] - half).min() < 0.5
        assert 0.2 < (mine[:, 8] + half).max() - hedge.x1 < 0.5
        assert (np.diff(np.sort(mine[:, 8])) < 1.9 * half.max()).all()
        np.testing.assert_allclose(top - street.kerb_height_m, hedge.height, rtol=0.05)


def test_a_hedge_is_seen_as_leaves(street: StreetSpec) -> None:
    hedge = next(h for h in hedges_of(street) if h.y < 0 and 20 < h.x0 < street.end_x_m - 30)
    camera = renderer(Weather())
    camera.load(street, Weather())
    moment = snapshot(x=hedge.x0 - 12.0)
    frame = camera.render(moment)
    middle, height = 0.5 * (hedge.x0 + hedge.x1), 0.6 * hedge.height
    u, v, _ = project(camera_pose(camera.config, moment.ego), np.array([[middle, hedge.y, height]]))[0]
    part = np.s_[int(v) - 3 : int(v) + 4, int(u) - 6 : int(u) + 7]
    assert frame.instance is not None
    assert (frame.instance[part] == StaticClass.VEGETATION).mean() > 0.8
    assert frame.luminance[part].std() > 0.1 * frame.luminance[part].mean()

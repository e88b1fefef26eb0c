"""Figures: every panel draws for any contact, and what is drawn is what was solved."""

from __future__ import annotations

import io

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from matplotlib import pyplot

import roughcontact as rc
from roughcontact.panel.figures import make_figure
from roughcontact.testing.strategies import height_maps, problems

STEEL = rc.Elastic(210e9, 0.3)
BY_SUBJECT = {
    kind: [name for name in rc.panels if rc.panels[name].subject == kind] for kind in ("solution", "surface", "sweep")
}


@pytest.fixture(autouse=True)
def closed_figures():
    yield
    pyplot.close("all")


def draw(kind, subject, name, dark=False):
    """Draw a panel to the end, as saving does."""
    figure = make_figure(kind, subject, name, dark)
    figure.savefig(io.BytesIO(), format="png", dpi=60)
    return figure.axes[0]


@settings(max_examples=25, deadline=None, suppress_health_check=list(HealthCheck))
@given(made=problems(), dark=st.booleans(), data=st.data())
def test_every_panel_of_a_solution_draws(made, dark, data):
    problem, mean = made
    solution = problem.solve(pressure=mean, throw=False)
    draw("solution", solution, data.draw(st.sampled_from([None, *BY_SUBJECT["solution"]])), dark)


@settings(max_examples=15, deadline=None, suppress_health_check=list(HealthCheck))
@given(surface=height_maps(), dark=st.booleans(), data=st.data())
def test_every_panel_of_a_surface_draws(surface, dark, data):
    values = surface.values.copy()
    if data.draw(st.booleans()):
        values.flat[0] = np.nan
    sampled = rc.panel.SampledSurface(values, surface.own_grid, data.draw(st.booleans()))
    draw("surface", sampled, data.draw(st.sampled_from([None, *BY_SUBJECT["surface"]])), dark)

"""The experiments on the lens: what they find agrees, and their pictures and tables are whole."""

import pytest
from matplotlib.figure import Figure

from vr_envs.experiments.catalogue import EXPERIMENTS
from vr_envs.experiments.runner import silent


@pytest.fixture(scope="module", params=["lens-travel", "lens-height"])
def outcome(request):
    return EXPERIMENTS[request.param].run(silent)


def test_what_is_found_is_what_was_expected(outcome):
    for finding in outcome.findings:
        assert finding.agrees, finding


def test_tables_have_columns_of_equal_length(outcome):
    for columns in outcome.tables.values():
        assert len({len(values) for values in columns.values()}) == 1


def test_the_picture_is_drawn(outcome):
    figure = Figure(layout="constrained")
    outcome.draw(figure)
    figure.canvas.draw()
    assert len(figure.findobj(match=lambda artist: hasattr(artist, "get_xlabel"))) >= 3

"""Groups of markers hold what viewers draw."""

import pytest
import torch

from lift_lab.markers import POSITION_GOAL_MARKER_CFG, VisualizationMarkers
from lift_lab.sim import SimulationContext
from lift_lab.utils.errors import ConfigError


@pytest.fixture
def sim():
    sim = SimulationContext()
    yield sim
    sim.close()


@pytest.fixture
def markers(sim):
    return VisualizationMarkers(POSITION_GOAL_MARKER_CFG.replace(prim_path="/Visuals/goal"))


def test_a_group_belongs_to_the_simulation_it_was_made_in(sim, markers):
    assert VisualizationMarkers.of(sim) == [markers]
    other = SimulationContext()
    assert VisualizationMarkers.of(other) == []
    other.close()


def test_without_a_simulation_there_are_no_markers():
    SimulationContext.clear_instance()
    with pytest.raises(ConfigError, match="make a SimulationContext before"):
        VisualizationMarkers(POSITION_GOAL_MARKER_CFG.replace(prim_path="/Visuals/goal"))


def test_a_new_number_of_instances_starts_with_defaults(markers):
    markers.visualize(torch.ones(2, 3))
    assert markers.count == 2
    assert markers.quats_w.tolist() == [[1.0, 0.0, 0.0, 0.0]] * 2
    assert markers.scales.tolist() == [[1.0, 1.0, 1.0]] * 2
    assert markers.marker_indices.tolist() == [0, 0]


def test_what_is_not_given_stays(markers):
    markers.visualize(torch.ones(2, 3), marker_indices=[1, 2])
    markers.visualize(scales=torch.full((2, 3), 3.0))
    assert markers.positions_w.tolist() == [[1.0, 1.0, 1.0]] * 2
    assert markers.marker_indices.tolist() == [1, 2]
    assert markers.scales[0, 0] == 3.0


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"translations": torch.zeros(2, 2)}, "translations: expected shape"),
        ({"translations": torch.zeros(2, 3), "orientations": torch.zeros(3, 4)}, "orientations: expected shape"),
        ({"translations": torch.zeros(1, 3), "marker_indices": [3]}, r"in \[0, 3\)"),
    ],
)
def test_values_that_do_not_fit_are_refused(markers, values, message):
    with pytest.raises(ValueError, match=message):
        markers.visualize(**values)


def test_a_group_can_be_hidden(markers):
    assert markers.is_visible()
    markers.set_visibility(False)
    assert not markers.is_visible()

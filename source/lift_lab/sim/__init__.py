"""Simulation settings, spawners, physics schemas and the simulation context.

Import as Isaac Lab users do: ``import lift_lab.sim as sim_utils``.
"""

from .ignored import note_ignored
from .schemas import *
from .simulation_cfg import MujocoCfg, PhysxCfg, RenderCfg, SimulationCfg
from .simulation_context import SimulationContext
from .spawners import *

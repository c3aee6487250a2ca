"""Simulation settings, spawners, physics schemas and the simulation context.

Import as Isaac Lab users do: ``import lift_lab.sim as sim_utils``.
"""

from .ignored import *
from .schemas import *
from .simulation_cfg import *
from .simulation_context import *
from .spawners import *

"""A virtual test rig: campaigns of measurements made from a model, for planning tests and for teaching."""

from gearfem.rig.measure import measure
from gearfem.rig.plan import Plan, read_plan

__all__ = ["Plan", "measure", "read_plan"]

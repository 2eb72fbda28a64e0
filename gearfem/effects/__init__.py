"""Physical effects: one small file each, found by themselves; see `Effect` for what such a file holds."""

from gearfem.effects.effect import Effect, Parameter, modules, parameter

__all__ = ["Effect", "Parameter", "modules", "parameter"]

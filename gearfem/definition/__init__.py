"""The definition stage: a gear pair, its load and its drive."""

from gearfem.definition.setup import Gear, GearPair, Material, Member, Operation, Rack, Setup

__all__ = ["Gear", "GearPair", "Material", "Member", "Operation", "Rack", "Setup"]

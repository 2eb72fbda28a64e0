"""Wear of the flanks of a pair: as a volume and a shape, or growing over its life by Archard's law."""

from gearfem.wear.archard import Archard, wear_rates
from gearfem.wear.life import Life, wear_over
from gearfem.wear.volume import depth_for_volume, removed_volume
from gearfem.wear.worn import Worn

__all__ = ["Archard", "Life", "Worn", "depth_for_volume", "removed_volume", "wear_over", "wear_rates"]

"""The flanks of both gears: outlines with exact points, normals and curvatures."""

from gearfem.flank.flanks import Flanks, make_flanks, path_of_contact
from gearfem.flank.outline import Outline

__all__ = ["Flanks", "Outline", "make_flanks", "path_of_contact"]

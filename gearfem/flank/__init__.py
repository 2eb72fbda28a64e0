"""The flanks of both gears: outlines with exact points, normals and curvatures."""

from gearfem.flank.deviation import Deviation
from gearfem.flank.flanks import Flanks, make_flanks, path_of_contact
from gearfem.flank.lead import Lead
from gearfem.flank.measured import FittedFlank, fitted_flanks
from gearfem.flank.outline import Outline

__all__ = ["Deviation", "FittedFlank", "Flanks", "Lead", "Outline", "fitted_flanks", "make_flanks", "path_of_contact"]

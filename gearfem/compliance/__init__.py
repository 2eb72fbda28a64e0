"""Tooth compliance: deflection per line load over the load's position, teeth, bodies and coupling."""

from gearfem.compliance.body import BodyCompliance, annulus_wind_up, body_compliance, body_share, scale_body
from gearfem.compliance.castigliano import Castigliano, FilletMiddle, FormCircle, RootEnd
from gearfem.compliance.crack import CrackTable, crack_table, crack_tooth, cracked, deepest_crack
from gearfem.compliance.elasticity import PlaneStrain, PlaneStress
from gearfem.compliance.field import Field
from gearfem.compliance.finite_elements import FiniteElements
from gearfem.compliance.paper_mesh import LayerAndSides, PaperMesh, TwoLayers
from gearfem.compliance.record import Compliance, ComplianceCurve, ToothCompliance
from gearfem.compliance.solid import SolidElements
from gearfem.compliance.solid_curve import SolidCurve
from gearfem.compliance.solid_field import SolidField
from gearfem.compliance.solid_mesh import SolidMesh
from gearfem.compliance.stage import load_positions, make_compliance, with_error
from gearfem.compliance.supports import Bore, Root, RootChord
from gearfem.compliance.width_record import WidthInfluence, WidthProfile
from gearfem.compliance.worn import FlankResponse, flank_response, odd_tooth, worn_tooth

__all__ = [
    "BodyCompliance",
    "Bore",
    "Castigliano",
    "Compliance",
    "ComplianceCurve",
    "CrackTable",
    "Field",
    "FilletMiddle",
    "FiniteElements",
    "FlankResponse",
    "FormCircle",
    "LayerAndSides",
    "PaperMesh",
    "PlaneStrain",
    "PlaneStress",
    "Root",
    "RootChord",
    "RootEnd",
    "SolidCurve",
    "SolidElements",
    "SolidField",
    "SolidMesh",
    "ToothCompliance",
    "TwoLayers",
    "WidthInfluence",
    "WidthProfile",
    "annulus_wind_up",
    "body_compliance",
    "body_share",
    "crack_table",
    "crack_tooth",
    "cracked",
    "deepest_crack",
    "flank_response",
    "load_positions",
    "make_compliance",
    "odd_tooth",
    "scale_body",
    "with_error",
    "worn_tooth",
]

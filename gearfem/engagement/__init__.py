"""The engagement stage: contacts of all pairs, their shares of the load, and what follows over the pinion angle."""

from gearfem.engagement.carpet import Carpet, error_carpet
from gearfem.engagement.engage import Mesh, engage, mesh_force, standard_angles
from gearfem.engagement.iso6336 import IsoStiffness, iso6336_stiffness
from gearfem.engagement.record import Contacts, Engagement, MeshForce
from gearfem.engagement.width import FaceSlices
from gearfem.engagement.width_load import WidthLoad, load_over_width

__all__ = [
    "Carpet",
    "Contacts",
    "Engagement",
    "FaceSlices",
    "IsoStiffness",
    "Mesh",
    "MeshForce",
    "WidthLoad",
    "engage",
    "error_carpet",
    "iso6336_stiffness",
    "load_over_width",
    "mesh_force",
    "standard_angles",
]

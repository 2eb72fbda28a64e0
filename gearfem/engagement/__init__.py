"""The engagement stage: contacts of all pairs, their shares of the load, and what follows over the pinion angle."""

from gearfem.engagement.engage import Mesh, engage, mesh_force, standard_angles
from gearfem.engagement.iso6336 import IsoStiffness, iso6336_stiffness
from gearfem.engagement.record import Contacts, Engagement, MeshForce

__all__ = [
    "Contacts",
    "Engagement",
    "IsoStiffness",
    "Mesh",
    "MeshForce",
    "engage",
    "iso6336_stiffness",
    "mesh_force",
    "standard_angles",
]

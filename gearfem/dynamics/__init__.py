"""The dynamics stage: rigid, elastic and classical motion of a gear pair in its drive."""

from gearfem.dynamics.drive import make_drive, wheel_torque_sentence
from gearfem.dynamics.elastic import classical_motion, elastic_motion
from gearfem.dynamics.natural_modes import Modes, modes
from gearfem.dynamics.record import DriveTrain, ElasticMotion, RigidMotion
from gearfem.dynamics.rigid import rigid_motion, uniform_transport, unloaded_transport
from gearfem.dynamics.sweep import sweep
from gearfem.dynamics.sweep_record import Sweep, SweepPoint

__all__ = [
    "DriveTrain",
    "ElasticMotion",
    "Modes",
    "RigidMotion",
    "Sweep",
    "SweepPoint",
    "classical_motion",
    "elastic_motion",
    "make_drive",
    "modes",
    "rigid_motion",
    "sweep",
    "uniform_transport",
    "unloaded_transport",
    "wheel_torque_sentence",
]

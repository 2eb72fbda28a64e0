"""The sensing stage: what instruments read of a gear pair."""

from gearfem.sensing.instrument import Instrument, Resonance
from gearfem.sensing.requests import Request, observe, requests
from gearfem.sensing.system import System

__all__ = ["Instrument", "Request", "Resonance", "System", "observe", "requests"]

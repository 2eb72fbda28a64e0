"""Where model and measurement disagree, and which effect would close the gap."""

from gearfem.diagnosis.campaign import Campaign, Measurement, read_campaign
from gearfem.diagnosis.faults import Fault

__all__ = ["Campaign", "Fault", "Measurement", "read_campaign"]

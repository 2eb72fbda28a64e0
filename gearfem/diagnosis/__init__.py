"""Where model and measurement disagree, and which effect would close the gap."""

from gearfem.diagnosis.campaign import Campaign, Measurement, read_campaign
from gearfem.diagnosis.compare import compare
from gearfem.diagnosis.comparison import Comparison
from gearfem.diagnosis.faults import Fault
from gearfem.diagnosis.localise import Localisation, localise
from gearfem.diagnosis.system_bench import SystemBench

__all__ = ["Campaign", "Comparison", "Fault", "Localisation", "Measurement", "SystemBench", "compare", "localise", "read_campaign"]

"""Where model and measurement disagree, and which effect would close the gap: all in one, or step by step."""

from gearfem.diagnosis.averages import averaged
from gearfem.diagnosis.campaign import Campaign, read_campaign
from gearfem.diagnosis.compare import compare
from gearfem.diagnosis.diagnose import Diagnosis, choose, diagnose, fit
from gearfem.diagnosis.faults import Fault
from gearfem.diagnosis.localise import localise
from gearfem.diagnosis.measurement import Measurement
from gearfem.diagnosis.name import name
from gearfem.diagnosis.prove import prove
from gearfem.diagnosis.rank import rank
from gearfem.diagnosis.search import score
from gearfem.diagnosis.suggest import suggest
from gearfem.diagnosis.system_bench import bench_of
from gearfem.diagnosis.write import write_diagnosis

__all__ = [
    "Campaign",
    "Diagnosis",
    "Fault",
    "Measurement",
    "averaged",
    "bench_of",
    "choose",
    "compare",
    "diagnose",
    "fit",
    "localise",
    "name",
    "prove",
    "rank",
    "read_campaign",
    "score",
    "suggest",
    "write_diagnosis",
]

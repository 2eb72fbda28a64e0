"""Where model and measurement disagree, and which effect would close the gap: all in one, or step by step."""

from gearfem.diagnosis.comparing.averages import averaged
from gearfem.diagnosis.comparing.compare import compare
from gearfem.diagnosis.diagnose import Diagnosis, choose, diagnose, fit
from gearfem.diagnosis.fitting.score import score
from gearfem.diagnosis.localising.localise import localise
from gearfem.diagnosis.modelling.system_bench import bench_of
from gearfem.diagnosis.naming.name import name
from gearfem.diagnosis.proving.prove import prove
from gearfem.diagnosis.ranking.rank import rank
from gearfem.diagnosis.reading.campaign import Campaign, read_campaign
from gearfem.diagnosis.reading.faults import Fault
from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.diagnosis.suggest import suggest
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

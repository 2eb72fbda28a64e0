"""The straight line from a definition to motions: one function per stage, one record handed on."""

from __future__ import annotations

import dataclasses
from typing import Literal

from gearfem.compliance.record import Compliance, ComplianceCurve
from gearfem.definition.setup import Member, Setup
from gearfem.dynamics.record import ElasticMotion, RigidMotion
from gearfem.engagement.record import Engagement, MeshForce
from gearfem.flank import Flanks
from gearfem.foundation import Record

Stage = Literal["flank", "compliance", "engagement", "dynamics"]


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Results(Record):
    """The records of all stages that were run; later ones are None.

    Parameters
    ----------
    setup : Setup
        What it was computed from.
    flanks, compliance, engagement, mesh_force : records
        Of the stages of these names.
    comparison : tuple of (member, ComplianceCurve)
        The same compliance by other methods and supports, where asked for.
    rigid, elastic, classical : RigidMotion, ElasticMotion, ElasticMotion
        Motions of the three dynamic models.
    assumptions : tuple of str
        Everything that was assumed on the way, the definition's included.
    """

    setup: Setup
    flanks: Flanks
    compliance: Compliance | None = None
    comparison: tuple[tuple[Member, ComplianceCurve], ...] = ()
    engagement: Engagement | None = None
    mesh_force: MeshForce | None = None
    rigid: RigidMotion | None = None
    elastic: ElasticMotion | None = None
    classical: ElasticMotion | None = None
    assumptions: tuple[str, ...] = ()

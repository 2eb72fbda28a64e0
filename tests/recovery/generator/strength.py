"""How strongly a cause shows in a campaign once everything else that could imitate it has had its say.

The signature of the cause is weighed by a covariance of sensor noise and waviness (at three times their size, correlated
samples counted once), nuisances at their priors, index errors of all teeth at twice theirs, and variants of this
simulator's own form (other contact law, bodies and coupling). A strength of 1 is the size at which those imitate it.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from .gear import Array
from .mesh import NEAR, static
from .observe import STATIC_OF_ONE_GEAR, Spec, axis, measure
from .system import Scatter, System
from .tooth import ContactLaw

COARSE = 24
INDEX = 0.8


def coarse(spec: Spec) -> Spec:
    """The record with fewer samples and turns."""
    keep = spec.quantity in STATIC_OF_ONE_GEAR or spec.quantity == "dynamic_factor"
    return spec if keep else replace(spec, samples=COARSE, turns=min(spec.turns, 1.3 if spec.speed else 2.0))


class Scale:
    """Weighs signatures in the fit records of one campaign; `system` is the true pair without scatter and without causes."""

    def __init__(self, system: System, specs: list[Spec], model_form: bool = True, angle_known: bool = False) -> None:
        self.specs = [coarse(s) for s in specs if s.role != "holdout"]
        self.base = [measure(system, s) for s in self.specs]
        self.system = system
        rng = np.random.default_rng(1)
        noisy = replace(system, scatter=Scatter.draw(system.pair, rng))
        sigma = []
        for spec, base in zip(self.specs, self.base, strict=True):
            extra = 0.0
            if spec.quantity == "static_transmission_error":
                extra = 0.2
            elif spec.quantity in STATIC_OF_ONE_GEAR:
                extra = 1.0 if spec.quantity == "radial_runout" else 0.3
            elif spec.quantity == "dynamic_factor":
                extra = 0.3 * float(np.std(base))
            elif spec.speed:
                # near a resonance neither scatter nor a shift of stiffness acts in proportion
                extra = math.hypot(0.5 * float(np.std(measure(noisy, spec) - base)), 0.15 * float(np.std(base)))
            sigma.append(np.full(len(base), 3.0 * math.hypot(spec.noise, extra) * math.sqrt(self._correlated(spec))))
        self.sigma = np.concatenate(sigma)
        self.unit = np.stack(self._columns(system, model_form, angle_known), 1) / self.sigma[:, None]
        self.inner = np.linalg.inv(np.eye(self.unit.shape[1]) + self.unit.T @ self.unit)

    @staticmethod
    def _correlated(spec: Spec) -> float:
        return 1.0 if spec.quantity in (*STATIC_OF_ONE_GEAR, "dynamic_factor") else 6.0

    def _change(self, system: System) -> Array:
        return np.concatenate([measure(system, s) - b for s, b in zip(self.specs, self.base, strict=True)])

    def _columns(self, system: System, model_form: bool, angle_known: bool) -> list[Array]:
        pair = system.pair
        wide = 0.005 if angle_known else 0.29
        nudges: list[tuple[System, float]] = [
            (replace(system, compliance_scale=system.compliance_scale * 1.05), 1.0),
            (replace(system, torque_gain=system.torque_gain * 1.01), 1.0),
            (replace(system, angle_offset=system.angle_offset + 0.01 * pair.pitch), wide / 0.01),
            (replace(system, sensor=replace(system.sensor, gain=system.sensor.gain * 1.02)), 1.0),
            (replace(system, inertias=(system.inertias[0] * 1.02, system.inertias[1])), 1.0),
            (replace(system, inertias=(system.inertias[0], system.inertias[1] * 1.02)), 1.0),
            (replace(system, damping=system.damping * 1.3), 1.0),
        ]
        if model_form:
            other = ContactLaw(None) if system.contact.power else ContactLaw(0.9)
            nudges += [
                (replace(system, contact=other), 1.0),
                (replace(system, contact_scale=1.15), 1.0),
                (replace(system, body_scale=(1.15, 1.0)), 1.0),
                (replace(system, body_scale=(1.0, 1.15)), 1.0),
                (replace(system, beam_scale=1.1), 1.0),
                (replace(system, coupling=system.coupling - 0.1), 1.0),
                (replace(system, friction=system.friction + 0.015), 1.0),
            ]
        columns = [self._change(changed) * factor for changed, factor in nudges]
        at = np.cumsum([0] + [len(b) for b in self.base])
        for k, spec in enumerate(self.specs):
            if spec.constant:
                column = np.zeros(at[-1])
                column[at[k] : at[k + 1]] = 1e3
                columns.append(column)
        return columns + self._index(system, at)

    def _index(self, system: System, at: Array) -> list[Array]:
        counts = [gear.teeth for gear in system.pair.gears]
        block = np.zeros((at[-1], sum(counts)))
        for k, spec in enumerate(self.specs):
            rows = np.arange(at[k], at[k + 1])
            if spec.quantity == "pitch_deviation":
                tooth = axis(system, spec).astype(int) + spec.first_tooth
                block[rows, (counts[0] if spec.gear else 0) + tooth % counts[spec.gear]] += 2 * INDEX
            elif spec.quantity.endswith("transmission_error"):
                angle = axis(system, spec) + system.angle_offset
                part = static(system, angle, spec.torque).share
                pair = np.floor(angle / system.pair.pitch).astype(int)[:, None] + NEAR
                for j in range(len(NEAR)):
                    block[rows, pair[:, j] % counts[0]] += 2 * INDEX * part[:, j]
                    block[rows, counts[0] + pair[:, j] % counts[1]] += 2 * INDEX * part[:, j]
        return list(block.T)

    def of(self, changed: System) -> float:
        """Strength of what a changed system would show."""
        return self._norm(self.whiten(changed))

    def apart(self, own: Array, rivals: list[System]) -> float:
        """Strength that is left of a whitened signature when the rivals may take any amplitude."""
        block = np.stack([self.whiten(r) for r in rivals], 1)
        weighed = block - self.unit @ (self.inner @ (self.unit.T @ block))
        amplitude = np.linalg.lstsq(block.T @ weighed, weighed.T @ own, rcond=1e-9)[0]
        return self._norm(own - block @ amplitude)

    def whiten(self, changed: System) -> Array:
        return np.asarray(self._change(changed) / self.sigma)

    def _norm(self, s: Array) -> float:
        inside = self.unit.T @ s
        return math.sqrt(max(float(s @ s - inside @ self.inner @ inside), 0.0))

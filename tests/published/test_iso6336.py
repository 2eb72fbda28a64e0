"""Tooth stiffness of ISO/TR 6336-30, example 1, to all digits published."""

from __future__ import annotations

from gearfem.engagement.iso6336 import tooth_stiffness, virtual_teeth
from gearfem.foundation.units import DEG, N_PER_MM_UM


def test_iso_tr_6336_30_example_1():
    """z 17/103, m_n 8 mm, helix 15.8 deg, x 0.145/0, h_fP 1.4 modules; loaded above 100 N/mm, contact ratio not used by c'."""
    helix = 15.8 * DEG
    stiffness = tooth_stiffness(
        virtual_teeth=(virtual_teeth(17, helix), virtual_teeth(103, helix)),
        profile_shift=(0.145, 0.0),
        dedendum=(1.4, 1.4),
        contact_ratio=1.5,
        line_load=1e6,
        helix_angle=helix,
    )
    for name, ours, published in (
        ("c'_th", stiffness.theoretical_stiffness, 17.85584),
        ("c'", stiffness.single_stiffness, 12.37047),
    ):
        print(f"ISO/TR 6336-30, 1, {name}: {ours / N_PER_MM_UM:.5f}, published {published}, N/(mm um)")
        assert round(ours / N_PER_MM_UM, 5) == published
    assert stiffness.warnings == ()

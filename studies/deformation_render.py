"""Pictures of the deformed tooth and gear body, plane and solid, at true and at exaggerated scale, by von Mises stress.

    python studies/deformation_render.py studies/coal_combine/model.toml --out pictures [--gif] [--small]

The line load is that of the operation torque, all on one pair, at the outer point of single pair contact of each gear.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from common import HERE, gears

from gearfem import Setup, load_model
from gearfem.compliance import Bore, FiniteElements, Root
from gearfem.compliance.solid import SolidElements
from gearfem.flank import Outline
from gearfem.report import Rendering, write_render
from gearfem.report.render import opengl_works
from gearfem.report.render_solid import NO_OPENGL_3D, write_solid_render


def outer_single_contact(setup: Setup, outline: Outline, active: tuple[float, float]) -> float:
    """Return u one base pitch above the lowest contact point, where a pair on its own stands highest on the tooth."""
    roll = float(outline.roll_length(active[0])) + setup.pair.base_pitch
    return min(float(outline.parameter(roll)), active[1])


def plane_pictures(outline: Outline, u: float, load: float, name: Path, small: bool) -> list[Rendering]:
    """Draw tooth and body held at the bore, and the tooth alone, true and enlarged."""
    resolution = 1.0 if small else 3.0
    whole = FiniteElements(support=Bore(), resolution=resolution).field(outline, u, load)
    done = [
        write_render(whole, name.with_name(f"{name.name}_2d_true.png"), outline=outline, scale=1.0),
        write_render(whole, name.with_name(f"{name.name}_2d_enlarged.png"), outline=outline),
    ]
    if not small:
        # Seen from afar, a coarser mesh can still be told apart.
        fan = FiniteElements(support=Bore(), resolution=0.5 * resolution).field(outline, u, load, neighbours=2)
        alone = FiniteElements(support=Root(), resolution=resolution).field(outline, u, load)
        done.append(write_render(fan, name.with_name(f"{name.name}_2d_body_enlarged.png"), outline=outline, body=True))
        done.append(write_render(alone, name.with_name(f"{name.name}_2d_root_enlarged.png"), outline=outline))
    return done


def solid_pictures(setup: Setup, outline: Outline, u: float, load: float, name: Path, small: bool, gif: bool) -> list[Rendering]:
    """Draw the tooth alone, true and enlarged, and with its sector of the body; on request the tooth turning."""
    size = {"resolution": 0.5, "layers": 4} if small else {"resolution": 1.5, "layers": 12}
    width = setup.pair.face_width
    alone = SolidElements(support=Root(), **size).field(outline, u, width, load)
    turning = name.with_name(f"{name.name}_3d.gif") if gif else None
    done = [write_solid_render(alone, name.with_name(f"{name.name}_3d_enlarged.png"), outline=outline, turning=turning)]
    if not small:
        done.append(write_solid_render(alone, name.with_name(f"{name.name}_3d_true.png"), outline=outline, scale=1.0))
        sector = SolidElements(support=Bore(), resolution=1.5, layers=8).field(outline, u, width, load)
        done.append(write_solid_render(sector, name.with_name(f"{name.name}_3d_body_enlarged.png"), outline=outline))
    return done


def main(arguments: list[str] | None = None) -> list[Rendering]:
    """Draw all pictures, say what each shows and return them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("model", nargs="?", type=Path, default=HERE / "coal_combine" / "model.toml", help="model file (TOML)")
    parser.add_argument("--out", type=Path, required=True, help="folder for the pictures")
    parser.add_argument("--gif", action="store_true", help="also a GIF of each tooth in 3D, turning")
    parser.add_argument("--small", action="store_true", help="the pinion alone, on coarse meshes")
    options = parser.parse_args(arguments)
    setup = load_model(options.model)
    done: list[Rendering] = []
    for member, outline, active in list(gears(setup))[: 1 if options.small else 2]:
        u = outer_single_contact(setup, outline, active)
        load = setup.operation.pinion_torque / (setup.pair.pinion.base_radius * setup.pair.face_width)
        print(f"{member}: line load {load / 1e3:.4g} N/mm at the radius {1e3 * float(np.hypot(*outline.point(u))):.2f} mm")
        done += plane_pictures(outline, u, load, options.out / member, options.small)
        if opengl_works():
            done += solid_pictures(setup, outline, u, load, options.out / member, options.small, options.gif)
    for picture in done:
        print(f"{picture.path}: {picture.title} ({picture.renderer})")
    for notice in dict.fromkeys(picture.notice for picture in done if picture.notice):
        print(notice)
    if not opengl_works():
        print(NO_OPENGL_3D)
    return done


if __name__ == "__main__":
    main()

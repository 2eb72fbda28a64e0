"""Options and arguments that commands share, and the reading of the model that they name."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

import click

if TYPE_CHECKING:
    from gearfem.definition.setup import Setup
    from gearfem.effects import Effect

Command = TypeVar("Command", bound=Callable[..., None])
GEARS = click.Choice(["pinion", "wheel"])
SUPPORTS = click.Choice(["bore", "root", "root_chord"])

model_argument = click.argument("model", metavar="MODEL")
out_option = click.option("--out", required=True, metavar="DIR", help="Folder for the files; made if missing.")
sets_option = click.option(
    "--set", "overrides", multiple=True, metavar="KEY=VALUE", help="Replace a key of the model, as in TOML; may be repeated."
)
steps_option = click.option(
    "--steps", type=click.IntRange(200, 100_000), default=400, show_default=True, help="Steps of the pinion angle from -1 to +1 pitch."
)
support_option = click.option(
    "--support",
    type=SUPPORTS,
    default="bore",
    show_default=True,
    help="What is held: the whole gear at its bore, or the tooth at its root circle or on the chord of it.",
)


def _keep_effects(context: click.Context, option: click.Parameter, files: tuple[str, ...]) -> None:
    """Keep the files of effects for the reading of the model."""
    context.meta["gearfem.effects"] = files


effects_option = click.option(
    "--effects",
    multiple=True,
    metavar="FILE",
    expose_value=False,
    callback=_keep_effects,
    help="A Python file with effects of your own, which the model may name in [[effect]]; it is run. May be repeated.",
)


def model_command(command: Command) -> Command:
    """Return a command with a model, a folder, overrides and files of effects."""
    return model_argument(out_option(sets_option(effects_option(command))))


def load(model: str, overrides: tuple[str, ...]) -> Setup:
    """Return the model of a command, its overrides and further effects in it."""
    from gearfem.model import load_model

    # A refusal that only computing can find names the model too: the group adds it.
    click.get_current_context().find_root().obj = f"{model} with overrides" if overrides else model
    return load_model(model, overrides, effects=kinds())


def kinds() -> list[type[Effect]]:
    """Return the effects of the files that the command names."""
    files = click.get_current_context().meta.get("gearfem.effects", ())
    if not files:
        return []
    from gearfem.effects.catalogue import effects_from

    return [kind for file in files for kind in effects_from(file)]

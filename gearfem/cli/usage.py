"""Wrong words on the command line, said in one line: which option, what was found, what is allowed."""

from __future__ import annotations

import click
from click.exceptions import BadOptionUsage, BadParameter, MissingParameter, NoSuchOption, UsageError


def usage_line(error: UsageError) -> str:
    """Return a usage error of click in the form of an `InputError`.

    Parameters
    ----------
    error : UsageError
        As click raised it.

    Returns
    -------
    str
        One line without "error: ".
    """
    where, found, allowed = _parts(error)
    return f"{where}: found {found}; allowed: {allowed}"


def _parts(error: UsageError) -> tuple[str, str, str]:
    program = error.ctx.command_path if error.ctx is not None else "gearfem"
    if isinstance(error, MissingParameter) and error.param is not None:
        return _name(error.param), "nothing", f"{_allowed(error.param)}; it must be given, see {program} -h"
    if isinstance(error, BadParameter) and error.param is not None:
        return _name(error.param), error.message.partition(" is not ")[0].rstrip("."), _allowed(error.param)
    if isinstance(error, NoSuchOption):
        near = error.possibilities or (_options(error.ctx) if error.ctx is not None else [])
        return program, f"the unknown option {error.option_name}", ", ".join(near)
    found = error.message.rstrip(".")
    found = f"{found[:1].lower()}{found[1:]}"
    if isinstance(error, BadOptionUsage):
        if "requires an argument" in found:
            return error.option_name, "nothing behind it", "a value, as -h of the command shows it"
        return error.option_name, found, f"what {program} -h says of it"
    if error.ctx is not None and isinstance(error.ctx.command, click.Group):
        return program, found, ", ".join(error.ctx.command.list_commands(error.ctx))
    return program, found, f"what {program} -h says"


def _name(param: click.Parameter) -> str:
    return param.opts[0] if isinstance(param, click.Option) else str(param.metavar or param.name)


def _options(ctx: click.Context) -> list[str]:
    return [
        name for param in ctx.command.get_params(ctx) if isinstance(param, click.Option) for name in param.opts if name.startswith("--")
    ]


def _allowed(param: click.Parameter) -> str:
    kind = param.type
    if isinstance(kind, click.Choice):
        return " or ".join(map(str, kind.choices))
    words = (
        "an integer" if isinstance(kind, click.types.IntParamType) else "a number" if isinstance(kind, click.types.FloatParamType) else ""
    )
    if isinstance(kind, (click.IntRange, click.FloatRange)):
        return f"{words} from {kind.min:g} to {kind.max:g}" if kind.min is not None and kind.max is not None else words
    return words or str(param.metavar or "text")

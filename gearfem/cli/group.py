"""How the command line fails: one line on stderr and an exit status, never a traceback of foreseen errors."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import Any

import click

from gearfem.foundation.errors import InputError, SolveError

REFUSED, FAILED, INTERRUPTED = 2, 1, 130


class Commands(click.Group):
    """Commands whose foreseen errors end in one line: status 2 for bad input, 1 for a failed solve, 130 for Ctrl-C."""

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command and turn its errors into exit statuses."""
        try:
            return super().invoke(ctx)
        except InputError as error:
            _end(ctx, f"error: {error}", REFUSED)
        except (SolveError, FloatingPointError) as error:
            _end(ctx, f"error: {error}", FAILED)
        except KeyboardInterrupt:
            _end(ctx, "interrupted", INTERRUPTED)
        except OSError as error:
            # click itself ends quietly where the reader of a pipe has gone.
            if error.errno == errno.EPIPE:
                raise
            _end(ctx, f"error: {error.filename or 'file'}: {(error.strerror or str(error)).lower()}", FAILED)
        return None


def _end(ctx: click.Context, line: str, status: int) -> None:
    click.echo(" ".join(line.split("\n")), err=True)
    ctx.exit(status)


def folder(out: str) -> Path:
    """Return the output folder, refused before any computing if nothing can be written there.

    Parameters
    ----------
    out : str
        Path as the user gave it; missing folders are made when the first file is written.

    Raises
    ------
    InputError
        If it is a file, lies under one, or must not be written to.
    """
    path = Path(out)
    if path.exists() and not path.is_dir():
        raise InputError("--out", f"the file {out}", "a folder, new or existing")
    above = path.absolute()
    while not above.exists() and above != above.parent:
        above = above.parent
    if not above.is_dir():
        raise InputError("--out", f"{out}, which lies under the file {above}", "a folder, new or existing")
    if not os.access(above, os.W_OK | os.X_OK):
        raise InputError("--out", f"{out}, but {above} must not be written to", "a folder that can be written to")
    return path

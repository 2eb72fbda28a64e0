"""How the command line fails: one line on stderr and an exit status, never a traceback of foreseen errors."""

from __future__ import annotations

import contextlib
import errno
import signal
import sys
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path
from types import FrameType
from typing import Any

import click

from gearfem.cli.usage import usage_line
from gearfem.foundation.errors import EffectError, InputError, SolveError

REFUSED, FAILED, INTERRUPTED = 2, 1, 130


class Commands(click.Group):
    """Commands whose foreseen errors end in one line: status 2 for bad input, 1 for a failed solve, 130 for Ctrl-C."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read the words before the command."""
        try:
            return super().parse_args(ctx, args)
        except click.exceptions.NoArgsIsHelpError:
            raise
        except click.UsageError as error:
            _end(ctx, f"error: {usage_line(error)}", REFUSED)
        return []

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command and turn its errors into exit statuses."""
        lost: list[str] = []
        try:
            with _told_of(lost):
                return super().invoke(ctx)
        except InputError as error:
            of_model = ctx.obj and not error.where.startswith("--")
            _end(ctx, f"error: {error.in_file(ctx.obj) if of_model else error}", REFUSED)
        except click.exceptions.NoArgsIsHelpError:
            raise
        except click.UsageError as error:
            _end(ctx, f"error: {usage_line(error)}", REFUSED)
        except MemoryError as error:
            what = f" ({error})" if str(error) else ""
            _end(ctx, f"error: not enough memory{what}; a lower --resolution or fewer steps take less", FAILED)
        except EffectError as error:
            _end(ctx, *(("interrupted", INTERRUPTED) if lost else (f"error: {error}", REFUSED)))
        except (SolveError, FloatingPointError) as error:
            _end(ctx, f"error: {error}", FAILED)
        except KeyboardInterrupt:
            _end(ctx, "interrupted", INTERRUPTED)
        except OSError as error:
            # click itself ends quietly where the reader of a pipe has gone.
            if error.errno == errno.EPIPE:
                raise
            # A name that no file can have is the user's, and not a failure.
            status = REFUSED if error.errno == errno.ENAMETOOLONG else FAILED
            _end(ctx, f"error: {error.filename or 'file'}: {(error.strerror or str(error)).lower()}", status)
        except Exception:
            if not lost:
                raise
            _end(ctx, "interrupted", INTERRUPTED)
        return None


@contextlib.contextmanager
def _told_of(lost: list[str]) -> Iterator[None]:
    """Note interrupts, since some end as another error, as in the middle of a compilation or an import; end at SIGTERM as at Ctrl-C."""
    usual = sys.unraisablehook

    def hook(event: sys.UnraisableHookArgs) -> None:
        if issubclass(event.exc_type, KeyboardInterrupt):
            lost.append("interrupt")
        else:
            usual(event)

    def interrupt(number: int, frame: FrameType | None) -> None:
        lost.append("interrupt")
        raise KeyboardInterrupt

    def terminate(number: int, frame: FrameType | None) -> None:
        # Whatever is half written or computing in children goes on the way out.
        raise SystemExit(128 + number)

    sys.unraisablehook = hook
    # Python lets the main thread alone have signals; what whoever started the program has it ignore stays so.
    main = threading.current_thread() is threading.main_thread()
    handlers = {signal.SIGINT: interrupt, signal.SIGTERM: terminate} if main else {}
    heard = {number: handler for number, handler in handlers.items() if signal.getsignal(number) is not signal.SIG_IGN}
    before = {number: signal.signal(number, handler) for number, handler in heard.items()}
    try:
        yield
    finally:
        sys.unraisablehook = usual
        for number, handler in before.items():
            signal.signal(number, handler)


def _end(ctx: click.Context, line: str, status: int) -> None:
    shown = (c if c.isprintable() else c.encode("unicode_escape").decode() for c in line.replace("\n", " "))
    click.echo("".join(shown), err=True)
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
        If it has no name, is a file, lies under one, or cannot be made or written to.

    Notes
    -----
    Made and removed again, since some file systems allow by their permissions what they then refuse.
    """
    if not out.strip():
        raise InputError("--out", "a name without letters", "a folder, new or existing; . is the current one")
    path = Path(out)
    if path.exists() and not path.is_dir():
        raise InputError("--out", f"the file {out}", "a folder, new or existing")
    above = path.absolute()
    while not above.exists() and above != above.parent:
        above = above.parent
    if not above.is_dir():
        raise InputError("--out", f"{out}, which lies under the file {above}", "a folder, new or existing")
    try:
        _try_out(path)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise InputError("--out", f"{out}, where nothing can be written ({reason})", "a folder that can be written to") from None
    return path


def _try_out(path: Path) -> None:
    missing = [folder for folder in (path, *path.parents) if not folder.exists()]
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=path):
            pass
    finally:
        for folder in missing:
            with contextlib.suppress(OSError):
                folder.rmdir()

"""Mistakes in the words of a command, told as all others are: in one line."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click

from ncf_fenicsx.errors import SceneError

PROGRAM = "ncf-fenicsx"
NO_WORDS: Any = getattr(click.exceptions, "NoArgsIsHelpError", ())
"""Click's error for a command without any word, from version 8.2 on: its message is the help."""


def call(program: Callable[..., int | None]) -> int | None:
    """Exit code of a program of Typer; None is 0.

    Raises:
        SceneError: there is no such command or option, or a value is not one of those it takes.
    """
    try:
        return program(prog_name=PROGRAM, standalone_mode=False)
    except NO_WORDS as error:
        error.show()
        return int(error.exit_code)
    except click.ClickException as error:
        raise SceneError(_line(error)) from None


def _line(error: click.ClickException) -> str:
    """The mistake, after the command that it was made in."""
    context = getattr(error, "ctx", None)
    path = context.command_path if context else PROGRAM
    command = path.partition(" ")[2]
    words = error.format_message().rstrip(".")
    return f"{command + ': ' if command else ''}{words}; expected what {path} --help tells"

"""PETSc's version, and the calls of it whose form differs between versions."""

from __future__ import annotations

from typing import Any

from petsc4py import PETSc

REASONS: Any = PETSc.SNES.ConvergedReason
NO_NUMBER: int = getattr(REASONS, "DIVERGED_FUNCTION_NANORINF", None) or REASONS.DIVERGED_FNORM_NAN
"""SNES' reason where a residual is not a number; PETSc 3.25 has renamed it."""


def petsc_version() -> str:
    """Version of PETSc."""
    return ".".join(str(number) for number in PETSc.Sys.getVersion())

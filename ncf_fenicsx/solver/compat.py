"""The calls of PETSc whose form differs between versions, and nothing else."""

from __future__ import annotations

from typing import Any

from petsc4py import PETSc

REASONS: Any = PETSc.SNES.ConvergedReason
NO_NUMBER: int = getattr(REASONS, "DIVERGED_FUNCTION_NANORINF", None) or REASONS.DIVERGED_FNORM_NAN
"""SNES' reason where a residual is not a number; PETSc 3.25 has renamed it."""

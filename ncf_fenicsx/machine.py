"""Where a figure was measured."""

from __future__ import annotations

import os
import platform
from pathlib import Path


def machine() -> str:
    """Processor, number of cores and host name."""
    names = [line.split(":", 1)[1].strip() for line in _processor_lines() if line.startswith("model name")]
    processor = names[0] if names else platform.processor() or platform.machine()
    return f"{processor}, {os.cpu_count()} cores, {platform.node()}"


def vector_flags() -> list[str]:
    """Options of a compiler for processors with AVX2, which all of x86 have had since 2015; none for others."""
    features = next((line.split() for line in _processor_lines() if line.startswith("flags")), [])
    return ["-march=x86-64-v3"] if {"avx2", "fma", "bmi2", "movbe", "f16c"}.issubset(features) else []


def _processor_lines() -> list[str]:
    file = Path("/proc/cpuinfo")
    return file.read_text(encoding="utf-8", errors="replace").splitlines() if file.exists() else []

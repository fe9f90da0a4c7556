"""Where a figure was measured."""

from __future__ import annotations

import os
import platform

from ncf_fenicsx.mesh.compat import processor_lines


def machine() -> str:
    """Processor, number of cores and host name."""
    names = [line.split(":", 1)[1].strip() for line in processor_lines() if line.startswith("model name")]
    processor = names[0] if names else platform.processor() or platform.machine()
    return f"{processor}, {os.cpu_count()} cores, {platform.node()}"

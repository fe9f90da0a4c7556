"""``python -m ncf_fenicsx``, the same as ``ncf-fenicsx``."""

from ncf_fenicsx.cli import main

main()

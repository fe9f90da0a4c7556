"""Pictures and pages, drawn from a results folder and nothing else."""

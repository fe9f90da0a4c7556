"""Where the runs of studies are done: processes of their own, on workers of a laptop or a cluster, a row for each."""

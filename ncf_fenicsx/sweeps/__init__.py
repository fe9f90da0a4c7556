"""Many runs of a scene: plans of inputs, runs on a laptop or a cluster, effects, indices and uncertainty."""

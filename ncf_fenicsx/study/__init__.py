"""Many runs of one scene, as a table and a map: how far it can be pushed."""

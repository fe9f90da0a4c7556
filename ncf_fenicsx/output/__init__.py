"""What is measured of an accepted state, and the files that hold it."""

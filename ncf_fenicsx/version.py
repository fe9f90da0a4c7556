"""Version of the program, for its package and for the records of its runs."""

VERSION = "0.1.0"

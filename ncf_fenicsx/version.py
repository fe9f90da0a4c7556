"""Version of the program, for its package and for the records of its runs."""

VERSION = "0.2.0.dev0"

"""Accuracy asked for by number: a sequence of runs, each finer than the last, with error bars."""

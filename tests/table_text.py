"""Columns of a made-up motion, and the text of a table of them."""

import numpy as np

from exports import motion

X, U = motion(100)
CM = X / 560  # cm
T = 0.005 * np.arange(100)


def lines(*columns, mark="\t"):
    return [mark.join(repr(float(v)) for v in row) for row in zip(*columns, strict=True)]


def text(*columns, mark="\t", head=None):
    return "\n".join(([head] if head else []) + lines(*columns, mark=mark)) + "\n"

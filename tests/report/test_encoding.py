"""What a page holds reads back: whole numbers and numbers exactly, fields to the rounding that is stated."""

import base64
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ncf_fenicsx.report import encoding

pytestmark = pytest.mark.serial


def unpacked(encoded, kind):
    """The numbers in an encoded array, as the page's script reads them."""
    planes = np.frombuffer(zlib.decompress(base64.b64decode(encoded["data"])), np.uint8)
    return planes.reshape(np.dtype(kind).itemsize, -1).T.copy().view(kind).reshape(encoded["shape"])


@given(
    arrays(
        np.float64,
        st.tuples(st.integers(1, 5), st.integers(1, 7)),
        elements=st.floats(-1e9, 1e9, allow_subnormal=False),
    )
)
def test_a_field_reads_back_to_half_a_step(values):
    encoded = encoding.series(values)
    whole = np.cumsum(unpacked(encoded, np.uint16), axis=0, dtype=np.uint16)
    back = encoded["low"] + encoded["step"] * whole
    room = 1e-9 * np.abs(values).max()  # of the floating-point numbers themselves
    assert np.abs(back - values).max() <= encoded["step"] / 2 + room
    assert encoded["step"] == 0 or np.isclose(encoded["step"] * encoding.LEVELS, np.ptp(values))


@given(arrays(np.int64, st.tuples(st.integers(1, 6), st.integers(1, 8)), elements=st.integers(-1, 2**31 - 1)))
def test_whole_numbers_read_back_exactly(values):
    back = np.cumsum(unpacked(encoding.table(values), np.int32), axis=0, dtype=np.int32)
    assert (back == values).all()


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_numbers_read_back_exactly(kind):
    values = np.random.default_rng(0).standard_normal((4, 3)).astype(kind)
    encoded = encoding.numbers(values)
    assert encoded["bits"] == 8 * values.itemsize
    assert (unpacked(encoded, kind) == values).all()

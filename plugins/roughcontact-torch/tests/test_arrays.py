"""Tensors behind numpy's protocols give what numpy gives: the same types, and the same values up to rounding."""

import itertools

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from roughcontact_torch import TensorArray

DTYPES = (np.bool_, np.int32, np.int64, np.float32, np.float64)
NUMBERS = (2, 0.5, np.float32(0.25), np.float64(3.0))
ARITHMETIC = (np.add, np.subtract, np.multiply, np.divide, np.minimum, np.maximum, np.less, np.greater_equal, np.equal)


def tensor(values):
    return TensorArray(torch.tensor(values))


def sample(dtype, seed=0, shape=(5, 4)):
    return np.random.default_rng(seed).integers(1, 9, shape).astype(dtype)


def assert_same(found, expected, **allowed):
    assert found.dtype == expected.dtype
    assert found.shape == expected.shape
    np.testing.assert_allclose(found.tensor.numpy(), expected, **allowed)


@pytest.mark.parametrize("ufunc", ARITHMETIC)
@pytest.mark.parametrize(("one", "other"), list(itertools.product(DTYPES, DTYPES)))
def test_types_of_two_arrays_promote_as_numpys(ufunc, one, other):
    if ufunc is np.subtract and np.bool_ is one is other:
        pytest.skip("numpy has no difference of masks")
    a, b = sample(one, 1), sample(other, 2)
    assert_same(ufunc(tensor(a), tensor(b)), ufunc(a, b), rtol=1e-6)
    assert_same(ufunc(a, tensor(b)), ufunc(a, b), rtol=1e-6)


@pytest.mark.parametrize("ufunc", ARITHMETIC)
@pytest.mark.parametrize(("dtype", "number"), list(itertools.product(DTYPES[1:], NUMBERS)))
def test_types_of_arrays_and_numbers_promote_as_numpys(ufunc, dtype, number):
    a = sample(dtype)
    assert_same(ufunc(tensor(a), number), ufunc(a, number), rtol=1e-6)
    assert_same(ufunc(number, tensor(a)), ufunc(number, a), rtol=1e-6)


@given(st.integers(0, 999), st.sampled_from(DTYPES[3:]))
def test_masked_and_in_place_operations(seed, dtype):
    rng = np.random.default_rng(seed)
    a, b, mask = rng.normal(size=(6, 5)).astype(dtype), rng.random((6, 5)), rng.random((6, 5)) < 0.4
    ours, given_ = tensor(a), tensor(b)

    def work(values, other, where):
        values *= np.float32(0.5)
        np.multiply(values, 3.0, out=values, where=where)
        np.maximum(values, 0.0, out=values, where=values > other)
        np.clip(values, -1.0, 1.0, out=values)
        np.copyto(values, 0.25, where=where)
        values[where] += 1.0
        values[1:3, ::2] -= other[1:3, ::2]
        return values

    assert_same(work(ours, given_, tensor(mask)), work(a, b, mask), rtol=1e-6)


@given(st.integers(0, 999), st.sampled_from(DTYPES[3:]))
def test_reductions(seed, dtype):
    rng = np.random.default_rng(seed)
    a, b = rng.random((2, 8, 6)).astype(dtype)
    mask, starts = rng.random((8, 6)) < 0.4, np.flatnonzero(np.r_[True, rng.random(7) < 0.5])

    def work(a, b, mask, flat):
        yield np.add.reduce(a, axis=None)
        yield np.add.reduce(a, axis=None, where=mask, dtype=np.float64)
        yield np.minimum.reduce(a.ravel(), where=mask.ravel(), initial=np.float64(0.5))
        yield np.minimum.reduce(flat, where=True, initial=np.inf)
        yield a.max()
        yield a.std()
        yield mask.any(axis=1)
        yield np.einsum("ij,ij->", a, b)
        yield np.einsum("i,i->", a.ravel(), b.ravel(), dtype=np.float64, casting="same_kind")
        yield np.add.reduceat(a, starts, axis=0)
        yield np.add.reduceat(a.T, starts, axis=1)
        yield np.where(mask, a, 0.0)
        yield np.repeat(mask, 2, axis=1)
        yield np.take(a, starts, axis=1) if starts.max() < 6 else a[starts]
        yield np.concatenate((flat[:3], flat[4:]))
        yield np.broadcast_to(flat[:1], (4, 2))
        yield np.moveaxis(a, 1, 0)[1::2]

    ours = work(tensor(a), tensor(b), tensor(mask), tensor(a.ravel()))
    for found, expected in zip(ours, work(a, b, mask, a.ravel()), strict=True):
        assert_same(found, expected, rtol=1e-5)


@given(st.integers(0, 999))
def test_lists_of_cells(seed):
    rng = np.random.default_rng(seed)
    mask, values = rng.random(60) < 0.3, rng.random(60).astype(np.float32)

    def work(mask, values, like):
        cells = np.flatnonzero(mask)
        yield cells
        counts = np.diff(np.searchsorted(cells, np.arange(10, 61, 10)), prepend=0)
        yield counts
        numbers = np.repeat(np.arange(6, like=like), counts)
        yield numbers
        yield np.bincount(numbers, weights=values.take(cells, mode="wrap"), minlength=6)
        yield np.count_nonzero(mask) + cells.size
        yield from np.divmod(cells, 7)
        field = np.zeros(60, dtype=np.float32, like=like)
        field[cells] = values[cells]
        yield field

    ours = work(tensor(mask), tensor(values), tensor(values))
    for found, expected in zip(ours, work(mask, values, values), strict=True):
        assert_same(found, np.asarray(expected), rtol=1e-6)


@pytest.mark.parametrize(
    "call",
    [np.asarray, np.ascontiguousarray, np.sort, np.fft.rfft, np.sin, np.add.accumulate, lambda a: np.einsum("i->", a)],
)
def test_what_is_not_listed_is_refused_and_nothing_is_copied_in_silence(call):
    with pytest.raises(TypeError, match=r"[Tt]ensor"):
        call(tensor(np.ones(3)))

"""Lanes: every operation gives on eight numbers the bytes that it gives on each; records and rows keep their places."""

import math

import numpy as np
import pytest
from numba.core.errors import TypingError

from vr_envs.envs.rows import row_records
from vr_envs.models.jit import kernel
from vr_envs.models.lane_records import block_at, empty_blocks, lane, lane_count, read_records, record_at, write_records
from vr_envs.models.lane_rows import blank_rows, gathered, load_lanes, scatter, store_lanes
from vr_envs.models.lanes import (
    all_lanes,
    any_lane,
    bits_of_float,
    float_of_bits,
    floor,
    negate,
    to_float,
    to_int,
    to_key,
    where,
)  # fmt: skip

WIDE = 23
RECORD = np.dtype(
    [("x", "f8"), ("n", "i8"), ("key", "u8"), ("flag", "i8"), ("a", "f8", (3,)), ("grid", "f8", (2, 3))], align=True
)
RNG = np.random.default_rng(3)
TWELVE, SEVEN = np.uint64(12), np.uint64(7)


@kernel
def bump(record, by):
    """What is done record by record: also to an array of two axes, which lanes need not know."""
    if record.n % 2 == 0:
        record.a[1] += by
    record.grid[1, record.n & 1] += record.x


@kernel
def work(state, action, row):
    """Every operation, on a plain record and action or on lanes of them; returns a number and a truth."""
    x = state.x * 2.0 + action[0] / (3.0 + abs(action[1])) - 1.0
    mask = (x > 1.0) & (state.n + 1 < 9) | (x == 0.0) ^ (state.n > 3)
    y = where(mask, math.sqrt(abs(x)), -x)
    y = max(min(y, 0.7, x), -0.3, 0.1 * x)
    for k in range(3):
        state.a[k] += y * k
    total = 0.0
    for k in range(3):
        total += state.a[k]
    if any_lane(negate(mask)):
        total = where(mask, total, floor(total * 3.0) / to_float(state.n + 2))
    state.x = x - math.copysign(total, x)
    state.n += where(x >= total, 2, -to_int(mask)) + (state.n >> 1) - (to_int(total * 8.0) & 5)
    state.flag = mask
    key = (to_key(state.key) ^ (to_key(state.n) >> SEVEN)) * SEVEN
    state.key = key
    state.x += to_float(key >> TWELVE) * 2.0**-52
    state.x = float_of_bits(bits_of_float(state.x) & ~(1 << 20))
    if any_lane(mask):
        for k in range(lane_count(state)):
            if lane(mask, k):
                bump(lane(state, k), 2.0)
    for k in range(row.shape[0]):
        row[k] = (x + k) * (y - k)
    return y, mask


@kernel
def one_by_one(states, actions, rows, numbers, truths):
    for i in range(numbers.shape[0]):
        numbers[i], truths[i] = work(record_at(states, i), actions[i].row, rows[i].row)


@kernel
def in_blocks(states, actions, rows, numbers, truths, live):
    for b in range(states.shape[0]):
        if all_lanes(load_lanes(live, 8 * b)):
            row = blank_rows(rows)
            number, truth = work(block_at(states, b), gathered(actions, 8 * b), row)
            scatter(row, rows, 8 * b)
            store_lanes(numbers, 8 * b, number)
            store_lanes(truths, 8 * b, truth)


def records(n):
    found = np.zeros(n, RECORD)
    found["x"], found["n"] = RNG.normal(size=n), RNG.integers(-20, 20, n)
    found["key"] = RNG.integers(0, 2**64 - 1, n, dtype=np.uint64)
    found["a"] = RNG.normal(size=(n, 3))
    return found


def outputs(n, width):
    return np.full((n, width), -7.0, np.float32), np.zeros(n), np.zeros(n, np.bool_)


@pytest.mark.parametrize("width", [3, 8, WIDE])
def test_lanes_give_the_same_bytes(width):
    given, actions = records(160), RNG.normal(size=(160, 2))
    given["x"][:3] = 0.0, -0.0, 0.5
    plain, (rows, numbers, truths) = given.copy(), outputs(160, width)
    one_by_one(plain, row_records(actions), row_records(rows), numbers, truths)
    blocks, everyone = empty_blocks(RECORD, 160), np.arange(160)
    write_records(blocks, everyone, given)
    rows_2, numbers_2, truths_2 = outputs(160, width)
    in_blocks(blocks, row_records(actions), row_records(rows_2), numbers_2, truths_2, np.ones(160, np.bool_))
    assert read_records(blocks, everyone).tobytes() == plain.tobytes()
    assert (rows.tobytes(), numbers.tobytes()) == (rows_2.tobytes(), numbers_2.tobytes())
    assert (truths == truths_2).all() and 20 < truths.sum() < 140


def test_records_of_blocks_are_plain_records_to_a_kernel():
    given, actions = records(21), RNG.normal(size=(21, 2))
    blocks, everyone = empty_blocks(RECORD, 21), np.arange(21)
    write_records(blocks, everyone, given)
    results = []
    for states in (given, blocks):
        rows, numbers, truths = outputs(21, 3)
        one_by_one(states, row_records(actions), row_records(rows), numbers, truths)
        results.append((rows.tobytes(), numbers.tobytes(), truths.tobytes()))
    assert results[0] == results[1]
    assert read_records(blocks, everyone).tobytes() == given.tobytes()


def test_a_block_that_is_not_live_is_left_alone():
    given = records(16)
    blocks, everyone, live = empty_blocks(RECORD, 16), np.arange(16), np.ones(16, np.bool_)
    live[11] = False
    write_records(blocks, everyone, given)
    rows, numbers, truths = outputs(16, 3)
    in_blocks(blocks, row_records(np.ones((16, 2))), row_records(rows), numbers, truths, live)
    after = read_records(blocks, everyone)
    assert after[8:].tobytes() == given[8:].tobytes() and (rows[8:] == -7.0).all()
    assert after[:8].tobytes() != given[:8].tobytes() and (rows[:8] != -7.0).all()


def test_some_records_are_read_and_written():
    given = records(30)
    blocks = empty_blocks(RECORD, 30)
    write_records(blocks, np.arange(30), given)
    some = np.array([29, 3, 8])
    assert read_records(blocks, some).tobytes() == given[some].tobytes()
    write_records(blocks, some, np.zeros(1, RECORD))
    given[some] = 0
    assert read_records(blocks, np.arange(30)).tobytes() == given.tobytes()
    assert blocks.ctypes.data % 64 == 0


@kernel
def pick(record, shift):
    """Elements by numbers that differ from record to record."""
    k = (record.n + shift) & 1
    record.x = record.a[k + 1] - record.a[k]


@kernel
def pick_one_by_one(states, shift):
    for i in range(states.shape[0]):
        pick(states[i], shift)


@kernel
def pick_in_blocks(blocks, shift):
    for b in range(blocks.shape[0]):
        pick(block_at(blocks, b), shift)


def test_elements_by_numbers_that_differ_from_lane_to_lane():
    given = records(16)
    blocks, everyone = empty_blocks(RECORD, 16), np.arange(16)
    write_records(blocks, everyone, given)
    chosen = (given["n"] + 3) & 1
    assert 0 < chosen[:8].sum() < 8
    pick_one_by_one(given, 3)
    pick_in_blocks(blocks, 3)
    assert given["x"].tolist() == [row["a"][k + 1] - row["a"][k] for row, k in zip(given, chosen, strict=True)]
    assert read_records(blocks, everyone).tobytes() == given.tobytes()


def test_a_branch_on_lanes_does_not_compile():
    @kernel
    def branches(blocks):
        x = block_at(blocks, 0).x
        return 1.0 if x > 0.0 else 2.0

    with pytest.raises(TypingError):
        branches(empty_blocks(RECORD, 8))


def test_a_key_does_not_meet_a_signed_integer():
    """Numba's plain numbers would become a float."""

    @kernel
    def mixes(blocks):
        block = block_at(blocks, 0)
        block.x = to_float(block.key + block.n)

    with pytest.raises(TypingError):
        mixes(empty_blocks(RECORD, 8))

"""The kernel cache: it survives a process, and an edit makes it compile anew."""

import os
import subprocess
import sys

import numpy as np

from vr_envs.models.jit import _repeated, bound, kernel

PROGRAM = """
import sys
sys.path.insert(0, {folder!r})
import mine
print(mine.twice(1.0), sum(mine.twice.stats.cache_hits.values()))
"""
KERNEL = """
from vr_envs.models.jit import kernel


@kernel
def twice(x):
    return {factor} * x
"""


def run(folder, factor):
    (folder / "mine.py").write_text(KERNEL.format(factor=factor))
    # -B: within one second Python would take its own cached bytecode of the earlier text, which has the same size
    program = PROGRAM.format(folder=str(folder))
    out = subprocess.run([sys.executable, "-B", "-c", program], capture_output=True, text=True, check=True)
    value, hits = out.stdout.split()
    return float(value), int(hits)


def test_a_kernel_outside_the_package_is_cached_until_it_is_edited(tmp_path):
    assert run(tmp_path, 2) == (2.0, 0)
    assert run(tmp_path, 2) == (2.0, 1)
    assert run(tmp_path, 3) == (3.0, 0)


def test_kernels_of_earlier_sources_are_removed_once_they_are_old(tmp_path, monkeypatch):
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    run(tmp_path, 2)
    earlier = list(tmp_path.rglob("mine.*.nb[ci]"))
    # the function moves, and its files have another name
    texts = ["# a line more\n" + KERNEL, "# a line more\n# and another\n" + KERNEL]
    monkeypatch.setitem(globals(), "KERNEL", texts[0])
    assert run(tmp_path, 2) == (2.0, 0)
    assert len(earlier) == 2 and all(path.exists() for path in earlier)
    for path in earlier:
        os.utime(path, (0.0, 0.0))
    monkeypatch.setitem(globals(), "KERNEL", texts[1])
    assert run(tmp_path, 2) == (2.0, 0)
    assert not any(path.exists() for path in earlier)
    assert len(list(tmp_path.rglob("mine.*.nb[ci]"))) == 4  # of the two texts since


def test_an_edit_of_a_kernel_in_the_file_beside_it_compiles_it_anew(tmp_path, monkeypatch):
    imports = "from beside import once\nfrom vr_envs.models.jit import kernel"
    caller = f"{imports}\n\n\n@kernel\ndef twice(x):\n    return 2.0 * once(x)"
    monkeypatch.setitem(globals(), "KERNEL", caller)
    for factor, hits in ((1.0, 0), (1.0, 1), (3.0, 0)):
        (tmp_path / "beside.py").write_text(
            f"from vr_envs.models.jit import kernel\n\n\n@kernel\ndef once(x):\n    return {factor} * x\n"
        )
        assert run(tmp_path, None) == (2.0 * factor, hits)


PAIR = """
from typing import NamedTuple

from vr_envs.models.jit import kernel


class {name}(NamedTuple):
    a: float


@kernel
def first(pair):
    return pair.a


def twice(x):
    return first({name}(2.0 * x))


twice.stats = first.stats
"""


def test_a_cached_kernel_of_a_type_that_is_gone_is_compiled_anew(tmp_path, monkeypatch):
    monkeypatch.setitem(globals(), "KERNEL", PAIR.replace("{name}", "Pair"))
    assert run(tmp_path, None) == (2.0, 0)
    assert run(tmp_path, None) == (2.0, 1)
    monkeypatch.setitem(globals(), "KERNEL", PAIR.replace("{name}", "Couple"))
    assert run(tmp_path, None) == (2.0, 0)


MAKER = """
from vr_envs.models.jit import kernel


def around(inner):
    @kernel
    def outer(x):
        return inner(x)

    return outer
"""
NESTED = """
from maker import around
from vr_envs.models.jit import kernel


@kernel
def first(x):
    return {factor} * x


@kernel
def second(x):
    return 10.0 * x


other = around(around(second))
other(1.0)
twice = around(around(first))
"""


def test_a_kernel_is_known_by_all_that_it_closes_over_and_by_their_text(tmp_path, monkeypatch):
    """Two that differ only in what an inner one closes over, and one that stands in another file and is edited."""
    (tmp_path / "maker.py").write_text(MAKER)
    monkeypatch.setitem(globals(), "KERNEL", NESTED)
    assert run(tmp_path, 2) == (2.0, 0)
    assert run(tmp_path, 2) == (2.0, 1)
    assert run(tmp_path, 3) == (3.0, 0)


@kernel
def _difference(pair):
    return pair[0].size - pair[1].size


def test_a_bound_call_takes_a_tuple_of_records_of_one_kind():
    kind = [("other", "f8"), ("size", "f8")]
    pair = np.array([(0.0, 5.0)], kind)[0], np.array([(0.0, 3.0)], kind)[0]
    call = bound(_difference, pair)
    del pair
    assert (call(), call()) == (2.0, 2.0)


@kernel
def _last(record):
    return record.many[-1]


def test_a_bound_call_keeps_the_address_of_a_record_and_not_its_numbers():
    """Number by number, the code for one of thousands takes minutes and gigabytes to compile."""
    sizes = []
    for count in (8, 512):
        record = np.zeros(1, [("many", "f8", (count,))])
        record["many"][0, -1] = count
        call = bound(_last, record[0])
        assert call() == count
        library = list(_repeated(_last).overloads.values())[-1].library
        sizes.append(len(str(library._get_module_for_linking())))
    assert sizes[1] < 1.1 * sizes[0]

"""Counted instructions: of an option that is None as many as of one that never was, of amplitude 0 more."""

import math

import numba
import numpy as np

from vr_envs.bench.features.instructions import _count, _machine, _optimised, instructions
from vr_envs.models.jit import kernel

WAVE = np.array([(0.0,)], np.dtype([("amplitude", "f8")]))[0]


@kernel
def never(x, n):
    for _ in range(n):
        x += math.sqrt(x)
    return x


@kernel
def pruned(x, n, wave):
    for _ in range(n):
        x += math.sqrt(x)
        if wave is not None:
            x += wave.amplitude * math.sin(x)
    return x


def count(function, *arguments):
    return instructions(function, tuple(numba.typeof(argument) for argument in arguments))


def test_an_option_that_is_none_leaves_no_instruction():
    absent, gone = count(pruned, 2.0, 3, None), count(never, 2.0, 3)
    assert absent.optimised == gone.optimised
    assert absent.machine == gone.machine
    assert absent.optimised.total() > 5 and absent.machine.total() > 5
    assert count(pruned, 2.0, 3, None) == absent  # counting leaves the code as it is


def test_an_option_of_amplitude_zero_is_found_out():
    idle, gone = count(pruned, 2.0, 3, WAVE), count(never, 2.0, 3)
    assert pruned(2.0, 3, WAVE) == never(2.0, 3)
    assert idle.optimised != gone.optimised
    more = idle.calculation() - gone.calculation()
    assert more["fmul"] >= 1 and more["load"] >= 1
    assert any("sin" in kind for kind in more)
    assert idle.machine.total() > gone.machine.total()


CODE = """
declare double @sin(double)

define linkonce_odr i32 @entry(double* %x) local_unnamed_addr {
  call void @llvm.lifetime.start.p0(i64 8, ptr %x)
  %.1 = tail call fast double @"inner"(double 0.0)
  %.2 = call double @sin(double %.1)
  store double %.2, ptr %x
  ret i32 0
}

define double @"inner"(double %x) {
  %y = fadd double %x, 1.0
  ret double %y
}

define void @wrapper() {
  %r = call i32 @entry(ptr null)
  ret void
}
"""
ASSEMBLY = """
\t.text
entry:
\tpushq\t%rbx
\tmovabsq\t$inner, %rax
\tcallq\t*%rax
.LBB0_1:
\tretq
.Lfunc_end0:
\t.size\tentry, .Lfunc_end0-entry
inner:
\tvaddsd\t%xmm0, %xmm1, %xmm0
\tretq
wrapper:
\tcallq\tentry
"""


def test_counted_is_what_the_entry_calls_and_not_who_calls_it():
    assert _count(_optimised(CODE), "entry") == {"call": 1, "call sin": 1, "store": 1, "ret": 2, "fadd": 1}
    assert _count(_machine(ASSEMBLY), "entry") == {"pushq": 1, "movabsq": 1, "callq": 1, "retq": 2, "vaddsd": 1}

"""How many instructions a compiled kernel consists of: counted, so that no timer's noise decides.

Counted are the kernel and every compiled function that it calls and that the compiler has not inlined; not what Numba
puts around it for calls from Python, and not the mathematical library.
"""

from __future__ import annotations

import re
from collections import Counter
from typing import Any, NamedTuple

_LABEL = re.compile(r'^"?([^\s."#][^\s":]*)"?:')
_WORD = re.compile(r"[\w.]+")
_CALCULATES = re.compile(r"fadd|fsub|fmul|fdiv|frem|fneg|fcmp|load|call (?!llvm\.mem|NRT)")
_MARKER = "call void @llvm.lifetime"  # becomes no instruction
_INSTRUCTION = re.compile(r"^  (?:%\S+ = )?(?:tail |musttail |notail )?([a-z]+)\b")
_GLOBAL = re.compile(r'@"?([^\s"(,)]+)')

Bodies = dict[str, tuple[list[str], set[str]]]  # function -> its instructions, and what they name


class Instructions(NamedTuple):
    """How often each kind of instruction occurs: `.total()` is their number.

    `optimised`: of LLVM's intermediate code after all optimisation, `machine`: of the processor's. An argument of a
    call is part of the call in the former; in the latter it is moved to a register or pushed on the stack. A call of
    what is not compiled with the kernel, such as a sine, is a kind of its own.
    """

    optimised: Counter[str]
    machine: Counter[str]

    def calculation(self) -> Counter[str]:
        """Those of the optimised code that calculate: floats, loads, and calls of what is not compiled with it.

        The others also tell which functions the compiler has inlined.
        """
        return Counter({kind: n for kind, n in self.optimised.items() if _CALCULATES.match(kind)})


def instructions(dispatcher: Any, signature: Any) -> Instructions:
    """Of a kernel for arguments of the types `signature`."""
    dispatcher.compile(signature)
    overload = dispatcher.overloads[signature]
    library, entry = overload.library, overload.fndesc.mangled_name
    # what Numba links into callers: the optimised code, which a cached kernel has too
    code = library._get_module_for_linking()
    # of a copy, since making machine code of a module changes it
    assembly = library._codegen._tm.emit_assembly(code.clone())
    return Instructions(_count(_optimised(str(code)), entry), _count(_machine(assembly), entry))


def _count(bodies: Bodies, entry: str) -> Counter[str]:
    seen, waiting, found = set(), [entry], Counter()
    while waiting:
        name = waiting.pop()
        if name not in seen and name in bodies:
            seen.add(name)
            kinds, named = bodies[name]
            found.update("call" if kind.removeprefix("call ") in bodies else kind for kind in kinds)
            waiting += named
    return found


def _optimised(code: str) -> Bodies:
    """The functions of a text of LLVM's intermediate code."""
    found: Bodies = {}
    current: tuple[list[str], set[str]] | None = None
    for line in code.splitlines():
        if line.startswith("define"):
            current = found.setdefault(_GLOBAL.findall(line)[0], ([], set()))
        elif line.startswith("}"):
            current = None
        elif current is not None and _MARKER not in line and (instruction := _INSTRUCTION.match(line)) is not None:
            kind, names = instruction[1], _GLOBAL.findall(line)
            if kind == "call":
                current[1].update(names)
                kind = " ".join([kind, *names[:1]])
            current[0].append(kind)
    return found


def _machine(assembly: str) -> Bodies:
    """The functions of a listing in GNU syntax."""
    found: Bodies = {}
    current: tuple[list[str], set[str]] | None = None
    for line in assembly.splitlines():
        label = _LABEL.match(line)
        if label is not None:
            current = found.setdefault(label[1], ([], set()))
        elif current is not None and line.startswith("\t") and not line.startswith("\t."):
            kind, _, operands = line.strip().partition("\t")
            current[0].append(kind)
            current[1].update(_WORD.findall(operands))
    return found

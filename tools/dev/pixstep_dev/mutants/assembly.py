# SPDX-License-Identifier: MIT
"""Which small changes an assembly source offers: one condition, one register, one instruction.

Directives, what the preprocessor reads, and calls of macros are left alone; the instructions that
macros are made of are code like any other.
"""

import re
from collections.abc import Iterator

from pixstep_dev.mutants.operators import Mutant

_OPPOSITES = (
    ("relation", "breq", "brne"),
    ("relation", "brlo", "brsh"),
    ("relation", "brcs", "brcc"),
    ("relation", "brmi", "brpl"),
    ("relation", "brlt", "brge"),
    ("relation", "brts", "brtc"),
    ("relation", "sbrs", "sbrc"),
    ("relation", "sbis", "sbic"),
    ("arithmetic", "adc", "add"),
    ("arithmetic", "sbc", "sub"),
    ("arithmetic", "sbci", "subi"),
    ("arithmetic", "cpc", "cp"),
    ("arithmetic", "inc", "dec"),
    ("arithmetic", "adiw", "sbiw"),
    ("bits", "ror", "lsr"),
    ("bits", "rol", "lsl"),
    ("bits", "and", "or"),
    ("bits", "andi", "ori"),
    ("bits", "asr", "lsr"),
    ("bits", "sbi", "cbi"),
)
_OTHERS = (
    *("mov", "movw", "ldi", "ld", "ldd", "lds", "st", "std", "sts", "in", "out", "push", "pop"),
    *("clr", "ser", "tst", "com", "neg", "eor", "swap", "mul", "muls", "mulsu", "bst", "bld"),
    *("cpi", "cpse", "sei", "cli", "set", "clt", "sec", "clc", "nop", "lpm"),
    *("rjmp", "jmp", "rcall", "call", "ret", "reti", "brbs", "brbc", "brvs", "brvc"),
)
# Without one of these the file does not say where to go on.
_NEEDED = frozenset(("rjmp", "jmp", "ret", "reti"))
_CODES = frozenset(_OTHERS) | {code for _, *pair in _OPPOSITES for code in pair}
_PAIRS = frozenset(("movw", "adiw", "sbiw"))

_INSTRUCTION = re.compile(r"^(?:[ \t]*[.\w\\()@]+:)?[ \t]+(?P<code>[a-z]+)\b(?P<operands>[^;\n]*)")
_REGISTER = re.compile(r"\br(\d+)\b")
_NUMBER = re.compile(r"(?<![\w\\.])\d+(?![\w.])")
_NAMED = re.compile(
    r"(?:[YZ][ ]\+[ ]|,[ ])([A-Z][A-Z_0-9]+)$"
)  # an offset or a constant by its name
_BEGINS = re.compile(r"^(?:function[ ](\w+)|\.macro[ ](\w+)|([A-Za-z_]\w*):)", re.MULTILINE)


def mutants(file: str, text: str) -> list[Mutant]:
    """Return every change that a source offers, in the order of the text."""
    found = []
    at, goes_on = 0, False
    for line in text.splitlines(keepends=True):
        directive = goes_on or line.startswith("#")
        goes_on = directive and line.endswith("\\\n")
        instruction = None if directive else _INSTRUCTION.match(line)
        if instruction and instruction["code"] in _CODES:
            found += [_mutant(file, text, at, *change) for change in _changes(instruction)]
        at += len(line)
    return found


def _mutant(file: str, text: str, at: int, kind: str, span: tuple[int, int], wrong: str) -> Mutant:
    start, end = at + span[0], at + span[1]
    first, last = at, text.index("\n", end)
    while first > 0 and text.count(text[first - 1 : last]) > 1:  # the line before tells which
        first = text.rfind("\n", 0, first - 1) + 1
    inside = [next(filter(None, name.groups())) for name in _BEGINS.finditer(text, 0, start)]
    return Mutant(
        file, text.count("\n", 0, start) + 1, kind, start, text[start:end], wrong,
        inside[-1] if inside else "",
        _as_one_line(text[first:last]),
        _as_one_line(text[first:start] + wrong + text[end:last]),
    )  # fmt: skip


def _as_one_line(text: str) -> str:
    return " ".join(re.sub(r";[^\n]*", "", text).split())


def _changes(found: re.Match[str]) -> Iterator[tuple[str, tuple[int, int], str]]:
    """Yield kind, the place in the line, and what is put there."""
    code, operands = found["code"], found["operands"].rstrip()
    begin = found.start("operands")
    for kind, *pair in _OPPOSITES:
        if code in pair:
            yield kind, found.span("code"), pair[1 - pair.index(code)]
    if code not in _NEEDED:
        # Of the same length, in words, so that no other instruction moves out of a skip's reach.
        yield "statement", (found.start("code"), begin + len(operands)), "nop"
    for register in _REGISTER.finditer(operands):
        number = int(register[1])
        other = number ^ (2 if code in _PAIRS else 1)
        yield "register", _at(begin, register.span()), f"r{other}"
    if code.startswith("br") or code in ("rjmp", "jmp", "call", "rcall"):
        return
    for constant in _NUMBER.finditer(operands):
        for other in (int(constant[0]) + 1, int(constant[0]) - 1):
            if other >= 0:
                yield "constant", _at(begin, constant.span()), str(other)
    named = _NAMED.search(operands)
    if named:
        yield "constant", _at(begin, named.span(1)), f"{named[1]} + 1"


def _at(begin: int, span: tuple[int, int]) -> tuple[int, int]:
    return begin + span[0], begin + span[1]

# SPDX-License-Identifier: MIT
"""An AVR image as its disassembly tells it: functions, who calls whom, how much stack each takes.

The stack is counted from the code itself, the same for every compiler version: pushes, the frame
taken from the stack pointer, return addresses, and what the deepest callee takes on top.
"""

import re
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

FUNCTION = re.compile(r"^[0-9a-f]+ <(?P<name>[^>]+)>:$")
INSTRUCTION = re.compile(r"^\s*[0-9a-f]+:\t(?:[0-9a-f]{2} )+\s*\t(?P<op>\S+)(?:\s+(?P<rest>.*))?$")
TARGET = re.compile(r"<(?P<name>[^+>]+)(?P<offset>\+0x[0-9a-f]+)?>")
CALL_NEXT = re.compile(r"^\.\+0\b")  # a call of the next instruction: a short way to take stack
CALLS = {"call", "rcall"}
INDIRECT = {"icall", "eicall", "ijmp", "eijmp"}
ENDS = {"ret", "reti", "jmp", "rjmp", "ijmp", "eijmp"}

# libgcc's prologue for its large functions: entered where the registers to be saved begin, two
# bytes an instruction, with the frame's size in r27:r26; it then jumps back into the function.
SHARED_PROLOGUE = "__prologue_saves__"
SHARED_PROLOGUE_PUSHES = 18
FRAME_SIZE = {"r26": 1, "r27": 256}

# The linker's jumps in low flash to functions whose address is used.
TRAMPOLINES = "__trampolines_start"

# They jump through a register, but only back into the function that asked for it.
HELPERS = {"__tablejump2__", "__tablejump__", SHARED_PROLOGUE}


class ImageError(Exception):
    """The image cannot be judged; the message says why."""


@dataclass
class Function:
    """One function: its own stack use in bytes and where control may go from it."""

    name: str
    pushes: int = 0
    frame: int = 0
    calls: set[str] = field(default_factory=set)
    jumps: set[str] = field(default_factory=set)
    indirect: bool = False
    opens_interrupts: bool = False


@dataclass
class Image:
    """All functions of an ELF file. `return_bytes` is what a call puts on the stack."""

    functions: dict[str, Function]
    typed: set[str]
    return_bytes: int

    def reachable(self, start: str) -> set[str]:
        """Names of all functions that control may reach from one, itself included."""
        seen: set[str] = set()
        waiting = [start]
        while waiting:
            name = waiting.pop()
            if name not in seen and name in self.functions:
                seen.add(name)
                waiting += self.functions[name].calls | self.functions[name].jumps
        return seen

    def handlers(self) -> list[str]:
        """Interrupt handlers, by their vectors' names."""
        return sorted(name for name in self.functions if re.fullmatch(r"__vector_\d+", name))

    def deepest(self, start: str, trail: tuple[str, ...] = ()) -> tuple[int, list[str]]:
        """Worst stack bytes from a function's entry on, and the path that takes them."""
        function = self.functions[start]
        own = function.pushes + function.frame
        worst, path = own, []
        inside = (*trail, start)
        for callee in sorted(function.calls & self.functions.keys()):
            if callee in inside:
                raise ImageError("recursion: " + " -> ".join([*inside, callee]))
            below, below_path = self.deepest(callee, inside)
            if own + self.return_bytes + below > worst:
                worst, path = own + self.return_bytes + below, below_path
        for label in sorted((function.jumps & self.functions.keys()) - set(inside)):
            below, below_path = self.deepest(label, inside)
            # Before it jumps to a function, a compiler gives its own frame back; a jump to a
            # label of hand-written assembly keeps it.
            kept = 0 if label in self.typed else own
            if kept + below > worst:
                worst, path = kept + below, below_path
        return worst, [start, *path]


def run(command: list[str]) -> str:
    """Output of a program, or an ImageError with its complaint."""
    try:
        done = subprocess.run(command, capture_output=True, check=True, text=True)
    except FileNotFoundError as error:
        raise ImageError(f"{command[0]} is not installed") from error
    except subprocess.CalledProcessError as error:
        raise ImageError(f"{' '.join(command)}: {error.stderr.strip()}") from error
    return done.stdout


class Reader:
    """Walks the lines of a disassembly and fills in the functions."""

    def __init__(self) -> None:
        """Start with no function open."""
        self.functions: dict[str, Function] = {}
        self.current: Function | None = None
        self.last_operation = "ret"
        self.pointer_copied = False  # Y holds a copy of the stack pointer, its frame not yet taken
        self.constants: dict[str, int] = {}  # what ldi last put into a register of FRAME_SIZE

    def line(self, line: str) -> None:
        """One line: a function's head, an instruction or neither."""
        head = FUNCTION.match(line)
        if head:
            self.open_function(head["name"])
            return
        step = INSTRUCTION.match(line)
        if step and self.current:
            rest = (step["rest"] or "").strip()
            self.note_flow(self.current, step["op"], rest)
            self.note_stack(self.current, step["op"], rest)
            self.last_operation = step["op"]

    def open_function(self, name: str) -> None:
        """A new function; code that does not end may run on into it."""
        if self.current and self.last_operation not in ENDS:
            self.current.jumps.add(name)
        self.current = self.functions.setdefault(name, Function(name))
        self.pointer_copied = False

    def note_flow(self, function: Function, operation: str, rest: str) -> None:
        """Where control may go from one instruction."""
        target = TARGET.search(rest)
        if operation in INDIRECT:
            function.indirect = function.name not in HELPERS
        elif target and operation in CALLS and not CALL_NEXT.match(rest):
            function.calls.add(target["name"])
        elif target and operation in ENDS and target["name"] == SHARED_PROLOGUE:
            function.pushes += SHARED_PROLOGUE_PUSHES - int(target["offset"] or "0", 16) // 2
            function.frame += sum(w * self.constants.get(r, 0) for r, w in FRAME_SIZE.items())
        elif target and not target["offset"] and target["name"] != function.name:
            function.jumps.add(target["name"])

    def note_stack(self, function: Function, operation: str, rest: str) -> None:
        """What one instruction takes from the stack."""
        if operation == "push":
            function.pushes += 1
        elif operation == "rcall" and CALL_NEXT.match(rest):
            function.frame += 3
        elif operation == "sei":
            function.opens_interrupts = True
        elif operation == "in" and rest.startswith("r28, 0x3d"):
            self.pointer_copied = True
        elif operation == "out" and rest.startswith("0x3d"):
            self.pointer_copied = False
        elif operation == "ldi" and rest[:3] in FRAME_SIZE:
            self.constants[rest[:3]] = int(rest.split(";")[0].split(",")[1], 0)
        elif self.pointer_copied:
            function.frame += frame_part(operation, rest)


def frame_part(operation: str, rest: str) -> int:
    """Bytes that one subtraction from the copied stack pointer takes; both of a pair add up."""
    register, _, value = rest.split(";")[0].partition(",")
    weight = {("sbiw", "r28"): 1, ("subi", "r28"): 1, ("sbci", "r29"): 256}
    factor = weight.get((operation, register.strip()), 0)
    return factor * (int(value, 0) & 0xFF) if factor else 0


def called_by_pointer(functions: dict[str, Function], typed: set[str]) -> set[str]:
    """C functions that nobody calls by name and that are still in the image: their address is used.

    One that is called both by name and through a pointer is seen only on parts with large flash,
    where the linker gives each function whose address is used a jump in low flash.
    """
    low = functions.get(TRAMPOLINES, Function(TRAMPOLINES)).jumps
    named = {
        name
        for function in functions.values()
        if function.name != TRAMPOLINES
        for name in function.calls | function.jumps
    }
    alone = {name for name in typed - named if name != "main" and not name.startswith("__")}
    return alone | (low & typed)


def read_image(elf: Path, objdump: str = "avr-objdump") -> Image:
    """Disassemble an ELF file and note every function in it."""
    reader = Reader()
    for line in run([objdump, "-d", "-w", str(elf)]).splitlines():
        reader.line(line)
    if not reader.functions:
        raise ImageError(f"{elf}: no code in it")
    symbols = run([objdump, "-f", "-t", str(elf)])
    typed = {line.split()[-1] for line in symbols.splitlines() if re.search(r" F \.text", line)}
    pointers = called_by_pointer(reader.functions, typed)
    for function in reader.functions.values():
        if function.indirect:
            function.calls |= pointers
    # Parts with more than 128 KB of flash ("avr:6") have return addresses of three bytes.
    return Image(reader.functions, typed, 3 if "architecture: avr:6" in symbols else 2)

# SPDX-License-Identifier: MIT
"""An AVR image as its disassembly tells it: functions, who calls whom, how much stack each takes.

The stack is counted from the code itself, the same for every compiler version: pushes, the frame
taken from the stack pointer, return addresses, and what the deepest callee takes on top.

A call through a pointer may reach every function whose address is used. Which those are say the
relocations that the linker leaves in the image when asked (--emit-relocs).
"""

import bisect
import re
import subprocess
from pathlib import Path

from avr_stack import Function, Image, ImageError

SYMBOL = re.compile(
    r"^(?P<address>[0-9a-f]{8}) (?P<flags>.{7}) \.text\s+[0-9a-f]+ (?:\.\w+ )?(?P<name>\S+)$"
)
INSTRUCTION = re.compile(
    r"^\s*(?P<address>[0-9a-f]+):\t(?:[0-9a-f]{2} )+\s*\t(?P<op>\S+)(?:\s+(?P<rest>.*))?$"
)
STEP_REGISTER = re.compile(r"\br[2-6]\b")
TARGET = re.compile(r"\b0x(?P<address>[0-9a-f]+) <")
LOCAL_LABEL = re.compile(r"\.|L\d")
CALL_NEXT = re.compile(r"^\.\+0\b")  # a call of the next instruction: a short way to take stack
RELOCATION = re.compile(
    r"^[0-9a-f]{8} R_AVR_\w+_(?:GS|PM)\s+(?P<symbol>[^\s+]+)(?:\+0x(?P<offset>[0-9a-f]+))?$",
    re.MULTILINE,
)
STACK_POINTER = {"0x3d", "0x3e"}
# Y, a copy of the stack pointer; r1 is 0, the high byte of a frame below 256 bytes.
COMPUTED_FRAME = re.compile(r"(?:sub|sbc|movw?|pop) r2[89]\b(?!, r1$)")
CALLS = {"call", "rcall"}
INDIRECT = {"icall", "eicall", "ijmp", "eijmp"}
ENDS = {"ret", "reti", "jmp", "rjmp", "ijmp", "eijmp"}

# libgcc's prologue for its large functions: entered where the registers to be saved begin, two
# bytes an instruction, with the frame's size in r27:r26; it then jumps back into the function.
SHARED_PROLOGUE = "__prologue_saves__"
SHARED_PROLOGUE_PUSHES = 18
FRAME_SIZE = {"r26": 1, "r27": 256}

# Its counterpart returns from the function. The compiler may leave a jump behind it that nothing
# reaches, to a place beyond the function's end.
SHARED_EPILOGUE = "__epilogue_restores__"

# Stands for every table in flash.
DATA = "(data)"

# The linker's jumps in low flash to functions whose address is used.
TRAMPOLINES = "__trampolines_start"

# They jump through a register, but only back into the function that asked for it.
HELPERS = {"__tablejump2__", "__tablejump__", SHARED_PROLOGUE}


def run(command: list[str]) -> str:
    """Output of a program, or an ImageError with its complaint."""
    try:
        done = subprocess.run(command, capture_output=True, check=True, text=True)
    except FileNotFoundError as error:
        raise ImageError(f"{command[0]} is not installed") from error
    except subprocess.CalledProcessError as error:
        raise ImageError(f"{' '.join(command)}: {error.stderr.strip()}") from error
    return done.stdout


class Symbols:
    """Which function an address of the code lies in. Compilers' local labels do not count.

    Of several names at one address a C function's wins, then a table's, then a name that is not a
    weak alias.
    """

    def __init__(self, table: str) -> None:
        """Read the output of objdump -t."""
        best: dict[int, tuple[bool, bool, bool, str]] = {}
        for match in filter(None, map(SYMBOL.match, table.splitlines())):
            address, flags = int(match["address"], 16), match["flags"]
            if not LOCAL_LABEL.match(match["name"]):
                # Tables in flash are code to the disassembler: their one name keeps them apart.
                name = DATA if "O" in flags else match["name"]
                rank = ("F" in flags, "O" in flags, "w" not in flags, name)
                best[address] = max(best.get(address, rank), rank)
        self.starts = sorted(best)
        self.names = [best[start][-1] for start in self.starts]
        self.typed = {name for is_function, *_, name in best.values() if is_function}

    def at(self, address: int) -> str:
        """Name of the function around an address."""
        index = bisect.bisect_right(self.starts, address) - 1
        return self.names[index] if index >= 0 else DATA

    def offset(self, address: int) -> int:
        """Bytes from the start of that function."""
        return address - self.starts[max(0, bisect.bisect_right(self.starts, address) - 1)]


class Reader:
    """Walks the lines of a disassembly and fills in the functions."""

    def __init__(self, symbols: Symbols, return_bytes: int) -> None:
        """Start with no function open."""
        self.symbols = symbols
        self.return_bytes = return_bytes
        self.functions: dict[str, Function] = {}
        self.current: Function | None = None
        self.last_operation = "ret"
        self.returned = False  # the last instruction went to the shared epilogue
        self.address = 0
        self.pointer_copied = False  # Y holds a copy of the stack pointer, its frame not yet taken
        self.constants: dict[str, int] = {}  # what ldi last put into a register of FRAME_SIZE

    def line(self, line: str) -> None:
        """Take in one line if it is an instruction of a function."""
        step = INSTRUCTION.match(line)
        if not step:
            return
        name = self.symbols.at(int(step["address"], 16))
        if name == DATA:
            return
        if self.current is None or self.current.name != name:
            self.open_function(name)
        function = self.functions[name]
        self.address = int(step["address"], 16)
        rest = (step["rest"] or "").strip()
        if self.returned and step["op"] == "rjmp":
            self.returned = False
            return
        self.returned = step["op"] in ENDS and f"<{SHARED_EPILOGUE}" in rest
        if STEP_REGISTER.search(rest.split(";")[0]):
            function.step_registers = True
        self.note_flow(function, step["op"], rest)
        self.note_stack(function, step["op"], rest)
        self.last_operation = step["op"]

    def open_function(self, name: str) -> None:
        """A new function; code that does not end may run on into it."""
        if self.current and self.last_operation not in ENDS:
            self.current.jumps.add(name)
        self.current = self.functions.setdefault(name, Function(name))
        self.pointer_copied = False

    def note_flow(self, function: Function, operation: str, rest: str) -> None:
        """Where control may go from one instruction."""
        if operation in INDIRECT:
            function.indirect = function.name not in HELPERS
        match = TARGET.search(rest)
        if match is None or CALL_NEXT.match(rest):
            return
        address = int(match["address"], 16)
        target = self.symbols.at(address)
        if target == SHARED_PROLOGUE and operation in ENDS:
            function.pushes += SHARED_PROLOGUE_PUSHES - self.symbols.offset(address) // 2
            function.frame += sum(w * self.constants.get(r, 0) for r, w in FRAME_SIZE.items())
        elif operation in CALLS:
            function.calls.add(target)
        elif target == function.name and address <= self.address:
            function.loops.append((address, self.address))
        elif target != function.name and not self.is_switch_case(function, address):
            function.jumps.add(target)

    def is_switch_case(self, function: Function, address: int) -> bool:
        """Whether this is the linker's low jump to a label of a switch, not to a function."""
        return function.name == TRAMPOLINES and self.symbols.offset(address) > 0

    def note_stack(self, function: Function, operation: str, rest: str) -> None:
        """What one instruction takes from the stack."""
        if operation in ("push", "pop"):
            function.pushes += operation == "push"
            function.moves.append((self.address, 1 if operation == "push" else -1))
        elif operation == "rcall" and CALL_NEXT.match(rest):
            function.frame += self.return_bytes
            function.moves.append((self.address, self.return_bytes))
        elif operation == "sei":
            function.opens_interrupts = True
        elif operation == "ldi" and rest[:3] in FRAME_SIZE:
            self.constants[rest[:3]] = int(rest.split(";")[0].split(",")[1], 0)
        elif (operation, rest[:9]) == ("in", "r28, 0x3d"):
            self.pointer_copied = True
        elif operation == "out" and rest[:4] in STACK_POINTER:
            if not rest[6:].startswith(("r28", "r29")) and function.name not in HELPERS:
                function.unbounded = "sets the stack pointer from " + rest[6:9].strip()
            self.pointer_copied = False if rest[:4] == "0x3d" else self.pointer_copied
        elif self.pointer_copied:
            if (
                COMPUTED_FRAME.match(f"{operation} {rest}".rstrip())
                and function.name not in HELPERS
            ):
                function.unbounded = "takes a frame of computed size"
            function.frame += frame_part(operation, rest)


def frame_part(operation: str, rest: str) -> int:
    """Bytes that one subtraction from the copied stack pointer takes; both of a pair add up."""
    register, _, value = rest.split(";")[0].partition(",")
    weight = {("sbiw", "r28"): 1, ("subi", "r28"): 1, ("sbci", "r29"): 256}
    factor = weight.get((operation, register.strip()), 0)
    return factor * (int(value, 0) & 0xFF) if factor else 0


def called_by_pointer(relocations: str, about: str, symbols: Symbols) -> set[str]:
    """C functions whose address the program uses, by the relocations left in the image."""
    places = {}
    for match in filter(None, map(SYMBOL.match, about.splitlines())):
        places[match["name"]] = int(match["address"], 16)
    found = set()
    for match in RELOCATION.finditer(relocations):
        address = places.get(match["symbol"], 0) + int(match["offset"] or "0", 16)
        # Else a label inside a function, of a switch's table.
        if symbols.offset(address) == 0 and symbols.at(address) in symbols.typed:
            found.add(symbols.at(address))
    return found


def read_image(elf: Path, objdump: str = "avr-objdump") -> Image:
    """Disassemble an ELF file and note every function in it."""
    about = run([objdump, "-f", "-t", str(elf)])
    symbols = Symbols(about)
    # Parts with more than 128 KB of flash ("avr:6") have return addresses of three bytes.
    return_bytes = 3 if "architecture: avr:6" in about else 2
    reader = Reader(symbols, return_bytes)
    for line in run([objdump, "-d", "-w", str(elf)]).splitlines():
        reader.line(line)
    if not reader.functions:
        raise ImageError(f"{elf}: no code in it")
    note_pointers(elf, reader.functions, symbols, about, run([objdump, "-r", "-w", str(elf)]))
    return Image(reader.functions, symbols.typed, return_bytes)


def note_pointers(
    elf: Path, functions: dict[str, Function], symbols: Symbols, about: str, relocations: str
) -> None:
    """Let calls through pointers reach every function whose address is used."""
    indirect = [function for function in functions.values() if function.indirect]
    if indirect and "R_AVR_" not in relocations:
        names = ", ".join(function.name for function in indirect)
        raise ImageError(f"{elf}: {names} calls through a pointer: link with --emit-relocs")
    pointers = called_by_pointer(relocations, about, symbols) if indirect else set()
    for function in indirect:
        function.calls |= pointers

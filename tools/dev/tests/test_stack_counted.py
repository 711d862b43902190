# SPDX-License-Identifier: MIT
"""The count of the worst stack, on small images whose stack is known, and what it must refuse."""

import subprocess
import sys
from dataclasses import replace
from fractions import Fraction

import pytest
import sizes
from avr_image import read_image
from avr_stack import ImageError

from pixstep import natives
from pixstep.simulation.simulator import SimOptions, Simulator

PARTS = {"uno": "atmega328p", "mega": "atmega2560"}
RETURN = {"uno": 2, "mega": 3}  # bytes of a return address
BOARDS = tuple(PARTS)
HEAD = "typedef unsigned char u8; volatile u8 sink; __attribute__((noinline, noclone)) "
END = " int main(void) { deep(3); for (;;) { } }"


@pytest.fixture
def build(tmp_path):
    """Return a function that makes an image of a source's text: C, or assembly with .text in it."""

    def compiled(text, board="uno", *options, relocations=True):
        source = tmp_path / ("image.S" if ".text" in text else "image.c")
        source.write_text(text)
        image = tmp_path / "image.elf"
        words = ["avr-gcc", f"-mmcu={PARTS[board]}", "-Os", *options, source, "-o", image]
        words += ["-Wl,--emit-relocs"] if relocations else []
        subprocess.run(words, check=True)
        return image

    return compiled


def counted(image, board="uno"):
    return sizes.worst_stack(board, read_image(image))[0]


def functions(**bodies):
    """Return assembly of C functions, their instructions separated by semicolons."""
    lines = [".text"]
    for name, body in bodies.items():
        lines += [f".global {name}", f".type {name}, @function", f"{name}:"]
        lines += [instruction.strip() for instruction in body.split(";")]
    return "\n".join(lines) + "\n"


PUSH = "push r16"


@pytest.mark.parametrize("board", BOARDS)
def test_a_chain_of_calls(build, board):
    text = functions(
        main=f"{PUSH}; call a; call b; ret",
        a=f"{PUSH}; {PUSH}; call b; ret",
        b=f"{PUSH}; {PUSH}; {PUSH}; ret",
    )
    assert counted(build(text, board), board) == 3 * RETURN[board] + 6


def test_a_jump_to_a_function_gives_the_own_frame_back_and_to_a_label_does_not(build):
    tail = functions(main=f"{PUSH}; pop r16; jmp a", a=f"{PUSH}; {PUSH}; ret")
    assert counted(build(tail)) == 2 + 2
    label = tail.replace(".type a, @function", "")
    assert counted(build(label)) == 2 + 3


def test_interrupts_on_top_of_the_main_program(build):
    """Two open others, of a group of three only the deepest counts; of the rest the deepest."""
    text = functions(
        main=f"{PUSH}; ret",
        __vector_13=f"{PUSH}; sei; reti",
        __vector_18=f"sei; {PUSH}; {PUSH}; reti",
        __vector_19=f"sei; {PUSH}; {PUSH}; {PUSH}; reti",
        __vector_20="sei; reti",
        __vector_1=f"{PUSH}; {PUSH}; {PUSH}; {PUSH}; reti",
        __vector_2=f"{PUSH}; reti",
    )
    assert counted(build(text)) == (2 + 1) + (2 + 1) + (2 + 3) + (2 + 4)


DEEP = {
    "a frame": HEAD + "void deep(u8 n) { volatile u8 room[40];"
    " for (u8 i = 0; i < 40; i++) { room[i] = n; } }" + END,
    "a large frame": HEAD + "void deep(u8 n) { volatile u8 room[300];"
    " for (int i = 0; i < 300; i++) { room[i] = n; } }" + END,
    "a pointer": HEAD + "void low(u8 n) { sink = n; } __attribute__((noinline)) void high(u8 n)"
    " { volatile u8 room[9]; for (u8 i = 0; i < 9; i++) { room[i] = n; } }"
    " void (*volatile one)(u8) = high; __attribute__((noinline)) void deep(u8 n)"
    " { low(n); one(n); sink++; }" + END,
    "by name and by pointer": HEAD + "void high(u8 n)"
    " { volatile u8 room[9]; for (u8 i = 0; i < 9; i++) { room[i] = n; } }"
    " void (*volatile one)(u8) = high; __attribute__((noinline)) void more(u8 n)"
    " { volatile u8 room[5]; for (u8 i = 0; i < 5; i++) { room[i] = n; } one(n); sink++; }"
    " __attribute__((noinline)) void deep(u8 n) { high(n); more(n); sink++; }" + END,
    "a jump table": HEAD + "void low(u8 n) { volatile u8 room[7];"
    " for (u8 i = 0; i < 7; i++) { room[i] = n; } } __attribute__((noinline)) void deep(u8 n)"
    " { switch (n) { case 0: sink = 9; break; case 1: sink = 4; break; case 2: sink = 77; break;"
    " case 3: low(n); sink++; break; case 4: sink = 1; break; case 5: sink += 3; break;"
    " case 6: sink -= 5; break; default: sink = 0; } }" + END,
}
SHARED = HEAD + (
    "long far(long a, long b, long c, long d); void deep(u8 n) { volatile u8 room[20]; long"
    " a = n, b = sink, c = sink, d = sink; for (u8 i = 0; i < 20; i++) { room[i] = n; }"
    " sink = (u8)far(a, b, c, d); sink = (u8)(a * b + c * d + far(d, c, b, a) + a + b + c); }"
    " __attribute__((noinline)) long far(long a, long b, long c, long d)"
    " { return a * b - c * d; }" + END
)


def seen(image, board):
    """Stack that the program uses in the simulator."""
    with Simulator(SimOptions([(board, image)], Fraction(100))) as simulator:
        simulator.run(100_000)
        return simulator.stats()["boards"][0]["stack_used_bytes"]


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("what", DEEP)
@pytest.mark.parametrize("board", BOARDS)
def test_what_compilers_make_is_counted_to_the_byte(build, board, what):
    image = build(DEEP[what], board)
    assert counted(image, board) == seen(image, board)


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("board", BOARDS)
def test_shared_prologues_are_counted_to_the_byte(build, board):
    image = build(SHARED, board, "-mcall-prologues")
    assert "__prologue_saves__" in read_image(image).functions
    assert counted(image, board) == seen(image, board)


REFUSED = {
    "recursion: main -> a -> a": functions(main="call a; ret", a="call a; ret"),
    "recursion: main -> a -> b -> a": functions(
        main="call a; ret", a="call b; ret", b="call a; ret"
    ),
    "recursion: a -> b -> a": functions(main="call a; ret", a="call b; ret", b="jmp a"),
    "a: pushes in a loop": functions(main="call a; ret", a=f"{PUSH}; dec r16; brne a; ret"),
    "a circle of jumps that pushes: a -> b -> a": functions(
        main="call a; ret", a=f"{PUSH}; jmp b", b=f"{PUSH}; jmp a"
    ).replace(".type b, @function", "").replace(".type a, @function", ""),
    "a: sets the stack pointer from r24": functions(main="call a; ret", a="out 0x3d, r24; ret"),
}  # fmt: skip
COMPUTED = HEAD + (
    "void deep(u8 n) { volatile u8 *room = __builtin_alloca(n);"
    " for (u8 i = 0; i < n; i++) { room[i] = n; } }" + END
)
THROUGH_POINTER = HEAD + (
    "void deep(u8 n); void (*volatile one)(u8) = deep; void deep(u8 n) { if (n) { one(n - 1); }"
    " sink++; }" + END
)


@pytest.mark.parametrize("complaint", REFUSED)
def test_what_cannot_be_bounded_is_refused(build, complaint):
    with pytest.raises(ImageError, match=complaint):
        counted(build(REFUSED[complaint]))


def test_a_push_and_a_pop_in_a_loop_are_not(build):
    text = functions(main="call a; ret", a=f"{PUSH}; pop r16; dec r16; brne a; ret")
    assert counted(build(text)) == 2 + 2 + 1


def test_a_frame_of_computed_size_is_refused(build):
    with pytest.raises(ImageError, match=r"deep: (takes a frame of computed|sets the stack)"):
        counted(build(COMPUTED))


def test_recursion_through_a_pointer_is_refused(build):
    with pytest.raises(ImageError, match="recursion: main -> deep -> deep"):
        counted(build(THROUGH_POINTER))


def test_a_pointer_without_relocations_is_refused(build):
    with pytest.raises(ImageError, match="deep calls through a pointer: link with --emit-relocs"):
        counted(build(DEEP["a pointer"], relocations=False))


def filled(bytes_free):
    """Return the source of a Uno image that leaves so many bytes with its worst stack."""
    stack = 4  # main and one call
    fill = sizes.limits_of("uno").ram - sizes.CANARY_BYTES - stack - bytes_free - 1
    return f"char fill[{fill}]; {DEEP_LEAF}" + END


DEEP_LEAF = HEAD + "void deep(u8 n) { sink = n; }"


RESERVE = sizes.limits_of("uno").reserve


@pytest.mark.parametrize(("bytes_free", "status"), [(RESERVE, 0), (RESERVE - 1, 1), (0, 1)])
def test_the_rule_fails_when_less_than_the_reserve_is_left(build, bytes_free, status):
    image = build(filled(bytes_free))
    script = natives.source("tools/checks/sizes.py")
    done = subprocess.run(
        [sys.executable, script, f"uno={image}"], capture_output=True, text=True, check=False
    )
    assert f"left {bytes_free} bytes" in done.stdout
    assert done.returncode == status
    complaint = f"uno: {bytes_free} bytes of RAM left with the worst stack, at least {RESERVE}"
    assert (complaint in done.stdout) == bool(status)


def test_flash_must_be_left_over_too(monkeypatch):
    limits = replace(sizes.limits_of("uno"), flash_reserve=100)
    monkeypatch.setattr(sizes, "limits_of", lambda _board: limits)
    most = limits.flash - 100
    assert sizes.over_limits("uno", sizes.Size(most, 0, 0, RESERVE, [])) == []
    assert sizes.over_limits("uno", sizes.Size(most + 1, 0, 0, RESERVE, [])) == [
        f"uno: {most + 1} bytes of flash, at most {most}"
    ]

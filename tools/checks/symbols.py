# SPDX-License-Identifier: MIT
"""Rule: what must not be in an image. No float, no heap and no division of signed values anywhere:
`/ 2` of a signed value is such a division, where a shift does. In what an interrupt handler can
reach also no other software division, which takes hundreds of cycles. The registers of the step
interrupt, which it changes without saving, are used by nobody else.

    symbols.py IMAGE.elf...
"""

import re
import sys
from pathlib import Path

import boards
from avr_image import read_image
from avr_stack import Image, ImageError
from common import finish

HEAP = re.compile(r"^(malloc|calloc|realloc|free)$")
FLOAT = re.compile(
    r"^__(f\w+[sd]f\w*|(add|sub|mul|div|cmp|eq|ne|lt|le|gt|ge|neg|unord)[sd]f\d?"
    r"|fp_\w+|float\w*[sd]f|fix\w*[sd]f\w*)$"
)
SIGNED_DIVISION = re.compile(r"^__(div|mod|divmod)[qhpsd]i\d?$")
DIVISION = re.compile(r"^__u?(div|mod|divmod)[qhpsd]i\d?(_u?moddi3)?$")

# The step handlers' own code, and what only moves all registers to the stack and back.
STEP_HANDLER_CALLS = re.compile(r"^step_isr_(command|late)_\d$")
STEP_HANDLER_PARTS = re.compile(
    r"^(step_isr_(entry|execute|too_late|make_up|make_up_fast|catch_up|catch_up_entry|stretch"
    r"|set_counter|refill_late|another_high)_\d+"
    r"|__vectors|__prologue_saves__|__epilogue_restores__)$"
)

ANYWHERE = [
    (HEAP, "the heap"),
    (FLOAT, "floating point"),
    (SIGNED_DIVISION, "a division of signed values"),
]
IN_HANDLERS = [(DIVISION, "a software division")]


def forbidden_in(names: set[str], rules: list[tuple[re.Pattern[str], str]]) -> list[str]:
    """One phrase for each forbidden function among the names."""
    return [
        f"{what} ({name})"
        for name in sorted(names)
        for pattern, what in rules
        if pattern.match(name)
    ]


def step_register_users(image: Image, board: str) -> list[str]:
    """Functions outside the step handlers that touch a register of theirs."""
    handlers = {
        name
        for name in image.handlers()
        if any(STEP_HANDLER_CALLS.match(one) for one in image.reachable(name))
    }
    # Compare A of the axes' timers: the idle periods of a halted axis (step_isr.S).
    handlers |= {f"__vector_{number}" for number in boards.load(board).timer_vectors("COMPA")}
    # The pixel clock's, before it lets the step interrupts in (pixel_clock_isr.S).
    handlers.add(f"__vector_{boards.load(board).pixel_clock_vector}")
    return [
        name
        for name, function in sorted(image.functions.items())
        if function.step_registers and name not in handlers and not STEP_HANDLER_PARTS.match(name)
    ]


def check_image(path: Path, image: Image) -> list[str]:
    """Problems of one image."""
    problems = [f"{path.name}: {found}" for found in forbidden_in(set(image.functions), ANYWHERE)]
    problems += [
        f"{path.name}: {name} uses a register of the step interrupt (r2 to r6)"
        for name in step_register_users(image, path.stem.removeprefix("pixstep-"))
    ]
    for handler in image.handlers():
        reached = image.reachable(handler)
        found = forbidden_in(reached, IN_HANDLERS)
        found += [
            f"a call through a pointer ({name})"
            for name in sorted(reached)
            if image.functions[name].indirect
        ]
        problems += [f"{path.name}: {handler} reaches {what}" for what in found]
    return problems


def main() -> None:
    """Check the images named on the command line."""
    problems: list[str] = []
    handlers = 0
    for name in sys.argv[1:]:
        try:
            image = read_image(Path(name))
        except ImageError as error:
            problems.append(str(error))
            continue
        handlers += len(image.handlers())
        problems += check_image(Path(name), image)
    finish("symbols", f"{len(sys.argv) - 1} images, {handlers} interrupt handlers", problems)


if __name__ == "__main__":
    main()

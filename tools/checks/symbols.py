# SPDX-License-Identifier: MIT
"""Rule: what must not be in an image. No float and no heap anywhere; in what an interrupt handler
can reach also no software division, which takes hundreds of cycles.

    symbols.py IMAGE.elf...
"""

import re
import sys
from pathlib import Path

from avr_image import Image, ImageError, read_image
from common import finish

HEAP = re.compile(r"^(malloc|calloc|realloc|free)$")
FLOAT = re.compile(
    r"^__(f\w+[sd]f\w*|(add|sub|mul|div|cmp|eq|ne|lt|le|gt|ge|neg|unord)[sd]f\d?"
    r"|fp_\w+|float\w*[sd]f|fix\w*[sd]f\w*)$"
)
DIVISION = re.compile(r"^__u?(div|mod|divmod)[qhpsd]i\d?(_u?moddi3)?$")

ANYWHERE = [(HEAP, "the heap"), (FLOAT, "floating point")]
IN_HANDLERS = [(DIVISION, "a software division")]


def forbidden_in(names: set[str], rules: list[tuple[re.Pattern[str], str]]) -> list[str]:
    """One phrase for each forbidden function among the names."""
    return [
        f"{what} ({name})"
        for name in sorted(names)
        for pattern, what in rules
        if pattern.match(name)
    ]


def check_image(path: Path, image: Image) -> list[str]:
    """Problems of one image."""
    problems = [f"{path.name}: {found}" for found in forbidden_in(set(image.functions), ANYWHERE)]
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

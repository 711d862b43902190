# SPDX-License-Identifier: MIT
"""Rule: no module of an image exceeds its line in the table of docs/TIMING.md.

    module_sizes.py                  prints flash and RAM of each module of each board's image
    module_sizes.py --check FILE     the same, and fails if one exceeds its line in FILE
    module_sizes.py --write FILE     the same, and rewrites the table in FILE between its markers

Flash may exceed the line by FLASH_SLACK_BYTES, RAM may not. The sizes come from the linker's map,
those of modules that are optimised as one program from the image's symbols (whole_program.py).
Another compiler version makes different code: the rule then prints so and compares nothing.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import whole_program
from common import ROOT, board_names, build_folder, finish, repository_files, table_options
from map_file import GAPS, STUBS, WHOLE_PROGRAM, Bytes, Image, MapError, read_map
from modules import ModuleError, module_of, objects, short

from pixstep.errors import UserError
from pixstep_dev import markdown

TABLE = "modules"
FLASH_SLACK_BYTES = 16
NAMES = {"libgcc.a": "libgcc", "libc.a": "avr-libc", "libm.a": "avr-libc", STUBS: STUBS}
OBJECT = re.compile(r"^(?P<source>.+\.[cS])\.o(?:bj)?$")
COMPILER = re.compile(rb"GCC: \([^)\0]*\) ([\d.]+)")
COMPILER_LINE = re.compile(r"^Compiler of the modules: avr-gcc (?P<version>.+)\.$", re.MULTILINE)
ROW = re.compile(r"^\| `?(?P<name>[A-Za-z][^|`]*?)`? \| (?P<cells>[-\d |]+) \|$", re.MULTILINE)

Sizes = dict[str, dict[str, Bytes]]  # by module, then by board


@dataclass(frozen=True)
class Record:
    """What a document's table says."""

    compiler: str
    boards: list[str]
    sizes: Sizes


def sources_by_name(files: list[Path], root: Path = ROOT) -> dict[str, str]:
    """Module by the file name of each source of the firmware."""
    found: dict[str, str] = {}
    for file in files:
        path = file.relative_to(root).as_posix()
        if path.startswith("firmware/") and file.suffix in (".c", ".S"):
            if file.name in found:
                raise MapError(
                    f"two sources are called {file.name}: the map cannot tell them apart"
                )
            found[file.name] = short(module_of(path, root))
    return found


def module_name(owner: str, sources: dict[str, str]) -> str:
    """Name of the table's row for an object of the map."""
    match = OBJECT.match(owner)
    if match and match["source"] in sources:
        return sources[match["source"]]
    if owner.startswith("crt"):
        return "start-up code"
    return NAMES.get(owner, owner)


def by_module(image: Image, sources: dict[str, str]) -> dict[str, Bytes]:
    """Bytes of each module of an image."""
    found: dict[str, Bytes] = {}
    for owner, taken in image.objects.items():
        found.setdefault(module_name(owner, sources), Bytes()).add(taken.flash, taken.ram)
    return found


def of_whole_program(image: Image, elf: Path, build: Path, root: Path) -> dict[str, Bytes]:
    """Bytes of each module in what the linker optimised as one program; none if it did not."""
    if not image.whole:
        return {}
    made = [
        (short(module_of(source, root)), whole_program.read_symbols(path))
        for source, path in objects(build, root=root)
    ]
    symbols = whole_program.read_symbols(elf)
    return whole_program.by_module(image.whole, symbols, whole_program.owners(made))


def board_sizes(board: str, sources: dict[str, str], root: Path) -> tuple[dict[str, Bytes], str]:
    """Bytes of each module of a board's image, and the compiler's version."""
    build = build_folder(board, root)
    elf = build / "firmware" / f"pixstep-{board}.elf"
    try:
        image = read_map(elf.with_suffix(".map").read_text(encoding="utf-8"))
        found = by_module(image, sources)
        for module, taken in of_whole_program(image, elf, build, root).items():
            found.setdefault(module, Bytes()).add(taken.flash, taken.ram)
        if image.whole:
            del found[WHOLE_PROGRAM]
        return found, compiler_of(elf)
    except OSError as error:
        raise MapError(f"{error.filename}: {error.strerror}: build it first") from None
    except (MapError, ModuleError) as error:
        raise MapError(f"{elf.with_suffix('.map')}: {error}") from None


def compiler_of(elf: Path) -> str:
    """The compiler's words about itself in an image."""
    found = COMPILER.search(elf.read_bytes())
    if not found:
        raise MapError(f"{elf}: does not name its compiler")
    return found[1].decode()


def measure(boards: list[str], root: Path = ROOT) -> Record:
    """Read the maps of all boards' images."""
    sources = sources_by_name(repository_files(root), root)
    sizes: Sizes = {}
    compilers = set()
    for board in boards:
        found, compiler = board_sizes(board, sources, root)
        compilers.add(compiler)
        for module, taken in found.items():
            sizes.setdefault(module, {})[board] = taken
    if len(compilers) != 1:
        raise MapError(f"the images have several compilers: {', '.join(sorted(compilers))}")
    return Record(compilers.pop(), boards, sizes)


def table(record: Record) -> str:
    """A measurement as Markdown: a row for each module, the sums last."""
    head = ("module", *(f"{board} {what}" for board in record.boards for what in ("flash", "RAM")))
    rows = [(f"`{name}`", *cells(record, name)) for name in sorted(record.sizes)]
    sums = []
    for board in record.boards:
        taken = [boards[board] for boards in record.sizes.values() if board in boards]
        sums += [str(sum(one.flash for one in taken)), str(sum(one.ram for one in taken))]
    lines = [f"Compiler of the modules: avr-gcc {record.compiler}.", ""]
    return "\n".join(lines) + "\n" + markdown.table(head, [*rows, ("all", *sums)]) + "\n"


def cells(record: Record, module: str) -> list[str]:
    """The cells of a module's row; a dash where a board's image has none of it."""
    found = []
    for board in record.boards:
        taken = record.sizes[module].get(board)
        found += [str(taken.flash), str(taken.ram)] if taken else ["-", "-"]
    return found


def parse(text: str) -> Record:
    """Read the table of a document, without its sums."""
    part = re.search(rf"begin generated: {TABLE} -->\n(.*?)<!-- end", text, re.DOTALL)
    compiler = COMPILER_LINE.search(part[1]) if part else None
    head = re.search(r"^\| module \| (.+) \|$", part[1], re.MULTILINE) if part else None
    if not (part and compiler and head):
        raise MapError(f"no table between the markers of {TABLE!r}")
    boards = [words.removesuffix(" flash") for words in head[1].split(" | ")[::2]]
    sizes: Sizes = {}
    for row in ROW.finditer(part[1]):
        if row["name"] != "all":
            words = [word.strip() for word in row["cells"].split("|")]
            pairs = zip(boards, words[::2], words[1::2], strict=True)
            sizes[row["name"]] = {
                board: Bytes(int(flash), int(ram)) for board, flash, ram in pairs if flash != "-"
            }
    return Record(compiler["version"], boards, sizes)


def past_lines(now: Record, lines: Record) -> list[str]:
    """Complaints: modules past their lines, without a line, or with a line and no code."""
    found = []
    for board in now.boards:
        if board not in lines.boards:
            found.append(f"{board}: the table does not have this board")
            continue
        named = {name for name, sizes in lines.sizes.items() if board in sizes}
        there = {name for name, sizes in now.sizes.items() if board in sizes}
        found += [f"{board}: {name} has no line" for name in sorted(there - named - {GAPS})]
        gone = sorted(named - there - {GAPS})
        found += [f"{board}: {name} has a line and no code" for name in gone]
        for name in sorted((there & named) - {GAPS}):
            found += grown(f"{board}: {name}", now.sizes[name][board], lines.sizes[name][board])
    return found + [
        f"{board}: the table has it, firmware/avr/boards has not"
        for board in lines.boards
        if board not in now.boards
    ]


def grown(what: str, taken: Bytes, line: Bytes) -> list[str]:
    """Complaints about one module of one board."""
    found = []
    if taken.flash > line.flash + FLASH_SLACK_BYTES:
        found.append(f"{what}: {taken.flash} bytes of flash, its line is {line.flash}")
    if taken.ram > line.ram:
        found.append(f"{what}: {taken.ram} bytes of RAM, its line is {line.ram}")
    return found


def judge(now: Record, path: Path) -> list[str]:
    """Complaints about a document's table."""
    try:
        lines = parse(path.read_text(encoding="utf-8"))
    except MapError as error:
        raise MapError(f"{path}: {error}") from None
    if lines.compiler != now.compiler:
        print(f"{path} is of avr-gcc {lines.compiler}, the images of {now.compiler}: not compared")
        return []
    found = past_lines(now, lines)
    if found:
        found.append(
            f"if intended: build/venv/bin/python tools/checks/module_sizes.py --write {path}"
        )
    return found


def main() -> None:
    """Measure, print, write, judge."""
    options = table_options("Flash and RAM of each module of the images.")
    try:
        now = measure(board_names())
        if options.write:
            markdown.write(options.write, TABLE, table(now))
        problems = judge(now, options.check) if options.check else []
    except (MapError, UserError, OSError) as error:
        finish("module_sizes", "nothing measured", [str(error)])
    print(table(now))
    finish("module_sizes", f"{len(now.sizes)} modules of {len(now.boards)} boards", problems)


if __name__ == "__main__":
    main()

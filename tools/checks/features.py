# SPDX-License-Identifier: MIT
"""Rule: every feature switch compiles both ways for each board, and what it costs is in the table.

    features.py                  builds every board's image with each switch turned over, and
                                 prints what each feature takes of the board
    features.py --check FILE     the same, and fails if FILE's table is another
    features.py --write FILE     the same, and rewrites the table in FILE between its markers
    features.py --together       builds one image with all switches turned over, of one board of
                                 each set of defaults; with --each-board, of every board

The switches are the rows of firmware/build_features.def, their defaults those of
firmware/build_features.h. The boards' images have to be built; the others go to build/features.
A switch has to be worth some flash, or what it is there for stays in the image without it. Flash
may differ from the table by SLACK_BYTES, and with another compiler nothing is compared.
"""

import re
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from avr_stack import ImageError
from common import ROOT, board_names, build_folder, finish, table_options
from feature_builds import BuildError, Maker, read_build, run
from map_file import MapError
from module_sizes import compiler_of
from sizes import limits_of, memory_bytes

from pixstep.errors import UserError
from pixstep_dev import markdown

TABLE = "features"
SLACK_BYTES = 48
WORKERS = 2

ROW = re.compile(r'^FEATURE\((?P<bit>\d+), (?P<name>\w+), "(?P<meaning>[^"]*)"\)$', re.MULTILINE)
COMPILER_LINE = re.compile(r"^Compiler of the features: avr-gcc (?P<version>.+)\.$", re.MULTILINE)
TABLE_ROW = re.compile(r"^\| `(?P<name>\w+)` \| (?P<cells>.+) \|$", re.MULTILINE)
CELL = re.compile(
    r"(?P<default>on|off), (?P<flash>-?\d+) / (?P<ram>-?\d+)(?P<over>, does not fit)?"
)


@dataclass(frozen=True)
class Feature:
    """One row of build_features.def."""

    bit: int
    name: str
    meaning: str

    @property
    def switch(self) -> str:
        """Name of its macro."""
        return f"FEATURE_{self.name.upper()}"


@dataclass(frozen=True)
class Cost:
    """What a feature takes of a board, in bytes, and whether the board's default has it."""

    default: bool
    flash: int
    ram: int
    fits: bool

    def __str__(self) -> str:
        """The cell of the table."""
        default = "on" if self.default else "off"
        return f"{default}, {self.flash} / {self.ram}{'' if self.fits else ', does not fit'}"


Costs = dict[str, dict[str, Cost]]  # by feature, then by board


def read_features(text: str) -> list[Feature]:
    """The rows of the table of features."""
    return [Feature(int(m["bit"]), m["name"], m["meaning"]) for m in ROW.finditer(text)]


def defaults(board: str) -> dict[str, bool]:
    """Which switches are on in the board's image, as the compiler sees it."""
    words = ["avr-gcc", "-E", "-dM", "-Ifirmware", f"-DBOARD_FILE=<avr/boards/{board}.def>"]
    macros = run([*words, "-x", "c", "firmware/build_features.h"], ROOT)
    found = dict(re.findall(r"^#define ((?:FEATURE|BOARD)_\w+) (\S+)$", macros, re.MULTILINE))
    return {
        name: found.get(value, value) == "1"
        for name, value in found.items()
        if name.startswith("FEATURE_")
    }


def cost(board: str, maker: Maker, feature: Feature, usual: tuple[int, int], has: bool) -> Cost:
    """Build the image with the switch turned over and compare it with the default."""
    other = memory_bytes(board, maker.image(feature.switch, 0 if has else 1))
    more, less = (usual, other) if has else (other, usual)
    limits = limits_of(board)
    fits = more[0] <= limits.flash and more[1] <= limits.ram
    return Cost(has, more[0] - less[0], more[1] - less[1], fits)


def measure(features: list[Feature]) -> tuple[Costs, str, list[str]]:
    """What each feature takes of each board, the compiler's version, what does not compile."""
    costs: Costs = {feature.name: {} for feature in features}
    problems, jobs, compilers = [], [], set()
    with ThreadPoolExecutor(WORKERS) as pool:
        for board in board_names():
            folder = build_folder(board)
            elf = folder / "firmware" / f"pixstep-{board}.elf"
            compilers.add(compiler_of(elf))
            maker = Maker(read_build(folder, elf.stem), build_folder("features") / board)
            usual, has = memory_bytes(board, elf), defaults(board)
            for feature in features:
                about = (board, maker, feature, usual, has[feature.switch])
                jobs.append((board, feature, pool.submit(cost, *about)))
        for board, feature, job in jobs:
            try:
                costs[feature.name][board] = job.result()
            except (BuildError, ImageError) as error:
                turned = "off" if defaults(board)[feature.switch] else "on"
                problems.append(f"{board}: {feature.name} {turned}: {error}")
    if len(compilers) != 1:
        raise MapError(f"the images have several compilers: {', '.join(sorted(compilers))}")
    return costs, compilers.pop(), problems


def unlike() -> list[str]:
    """One board of each set of defaults: on the others the same code is turned over."""
    found: dict[tuple, str] = {}
    for board in board_names():
        found.setdefault(tuple(sorted(defaults(board).items())), board)
    return list(found.values())


def turn_all(features: list[Feature], boards: list[str]) -> list[str]:
    """Build boards with all their switches turned over; return what does not compile."""
    problems = []
    for board in boards:
        folder, has = build_folder(board), defaults(board)
        maker = Maker(read_build(folder, f"pixstep-{board}"), build_folder("features") / board)
        try:
            values = {one.switch: int(not has[one.switch]) for one in features}
            maker.image_with(values, "together")
        except BuildError as error:
            problems.append(f"{board}: all switches turned over: {error}")
    return problems


def worthless(costs: Costs) -> list[str]:
    """Switches that save no flash: what they are there for is in the image either way."""
    return [
        f"{board}: {name} is worth {one.flash} bytes of flash: its code stays without it"
        for name, boards in costs.items()
        for board, one in boards.items()
        if one.flash <= 0
    ]


def table(features: list[Feature], costs: Costs, compiler: str) -> str:
    """The costs as Markdown."""
    boards = board_names()
    head = ("feature", "what it is", *(f"{board}: default, flash / RAM" for board in boards))
    rows = [
        (
            f"`{one.name}`",
            one.meaning,
            *(str(costs[one.name].get(board, "-")) for board in boards),
        )
        for one in features
    ]
    return f"Compiler of the features: avr-gcc {compiler}.\n\n{markdown.table(head, rows)}\n"


def parse(text: str) -> tuple[Costs, str]:
    """The costs in a document and the version of their compiler."""
    part = re.search(rf"begin generated: {TABLE} -->\n(.*?)<!-- end", text, re.DOTALL)
    compiler = COMPILER_LINE.search(part[1]) if part else None
    head = (
        re.search(r"^\| feature \| what it is \| (.+) \|$", part[1], re.MULTILINE) if part else None
    )
    if not (part and compiler and head):
        raise MapError(f"no table between the markers of {TABLE!r}")
    boards = [words.partition(":")[0] for words in head[1].split(" | ")]
    costs: Costs = {}
    for row in TABLE_ROW.finditer(part[1]):
        cells = row["cells"].split(" | ")[-len(boards) :]
        found = zip(boards, map(CELL.fullmatch, cells), strict=True)
        costs[row["name"]] = {
            board: Cost(m["default"] == "on", int(m["flash"]), int(m["ram"]), not m["over"])
            for board, m in found
            if m
        }
    return costs, compiler["version"]


def differences(now: Costs, lines: Costs) -> list[str]:
    """Where the table says otherwise."""
    found = [
        f"the table has {name}: there is no such feature" for name in lines.keys() - now.keys()
    ]
    for name, boards in now.items():
        for board, one in boards.items():
            line = lines.get(name, {}).get(board)
            if line is None:
                found.append(f"{board}: {name} is not in the table")
            elif not alike(one, line):
                found.append(f"{board}: {name}: {one}; the table says {line}")
    return sorted(found)


def alike(one: Cost, line: Cost) -> bool:
    """Whether a line of the table is near enough."""
    same = (one.default, one.ram, one.fits) == (line.default, line.ram, line.fits)
    return same and abs(one.flash - line.flash) <= SLACK_BYTES


def judge(costs: Costs, compiler: str, path: Path) -> list[str]:
    """Complaints about a document's table."""
    lines, version = parse(path.read_text(encoding="utf-8"))
    if version != compiler:
        print(f"{path} is of avr-gcc {version}, the images of {compiler}: not compared")
        return []
    found = differences(costs, lines)
    if found:
        found.append(f"if intended: build/venv/bin/python tools/checks/features.py --write {path}")
    return found


def main() -> None:
    """Build, measure, print, write, judge."""
    options = table_options("What each feature takes of each board.", "--together", "--each-board")
    source = ROOT / "firmware" / "build_features.def"
    features = read_features(source.read_text(encoding="utf-8"))
    boards = unlike() if options.together and not options.each_board else board_names()
    looked_at = f"{len(features)} switches of {len(boards)} boards"
    try:
        if options.together:
            finish("features", f"{looked_at}, turned over together", turn_all(features, boards))
        costs, compiler, problems = measure(features)
        text = table(features, costs, compiler)
        problems += worthless(costs)
        if options.write and not problems:
            markdown.write(options.write, TABLE, text)
        if options.check:
            problems += judge(costs, compiler, options.check)
    except (BuildError, ImageError, MapError, UserError, OSError) as error:
        finish("features", "nothing measured", [str(error)])
    print(text)
    finish("features", looked_at, problems)


if __name__ == "__main__":
    main()

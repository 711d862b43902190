# SPDX-License-Identifier: MIT
"""The rule about each module's flash and RAM: it must find a module that grew past its line."""

import map_file
import module_sizes
import pytest
import whole_program
from map_file import Bytes, MapError, Part, Section

from pixstep_dev import markdown

MAP = """\
Archive member included to satisfy reference by file (symbol)

Discarded input sections

 .text          0x0000000000000000      0x999 firmware/libapp.a(gone.c.obj)

Linker script and memory map

.text           0x0000000000000000       0x60
 *(.vectors)
 .vectors       0x0000000000000000       0x10 /usr/lib/avr/lib/avr5/crtatmega328p.o
                0x0000000000000000                __vectors
 .progmem.data.a_table_with_a_long_name
                0x0000000000000010        0x7 firmware/libapp.a(data.c.obj)
 *fill*         0x0000000000000017        0x1\x20
 .text.data_write
                0x0000000000000018       0x28 firmware/libapp.a(data.c.obj)
                0x0000000000000018                data_write
 .text          0x0000000000000040       0x10 firmware/CMakeFiles/p.dir/avr/hal/isr.S.obj
 .text.libgcc   0x0000000000000050       0x10 /usr/lib/gcc/avr/5.4.0/avr5/libgcc.a(_mul.o)
                0x0000000000000060                _etext = .

.data           0x0000000000800100        0x4 load address 0x0000000000000060
 .data          0x0000000000800100        0x4 firmware/libapp.a(data.c.obj)

.bss            0x0000000000800104       0x13
 COMMON         0x0000000000800104       0x13 firmware/libapp.a(data.c.obj)

.eeprom         0x0000000000810000        0x8
 .eeprom        0x0000000000810000        0x8 firmware/libapp.a(data.c.obj)

.comment        0x0000000000000000       0x11
 .comment       0x0000000000000000       0x11 firmware/libapp.a(data.c.obj)
"""


def test_each_byte_has_an_owner():
    image = map_file.read_map(MAP)
    assert image.objects == {
        "crtatmega328p.o": Bytes(0x10, 0),
        "data.c.obj": Bytes(0x33, 0x17),
        "gaps": Bytes(1, 0),
        "isr.S.obj": Bytes(0x10, 0),
        "libgcc.a": Bytes(0x10, 0),
    }
    assert image.total == Bytes(0x64, 0x17)


@pytest.mark.parametrize("line", [" *fill* ", " COMMON ", " .data  "])
def test_bytes_without_an_owner_are_refused(line):
    rows = [row for row in MAP.splitlines() if not row.startswith(line)]
    with pytest.raises(MapError, match="its sections"):
        map_file.read_map("\n".join(rows))


def test_a_file_without_a_memory_map_is_refused():
    with pytest.raises(MapError, match="no memory map"):
        map_file.read_map("nothing\n")


@pytest.fixture
def root(tmp_path):
    """Return a tree with two sources and the build of a board."""
    for name in ("firmware/app/data.c", "firmware/avr/hal/isr.S", "build/one/firmware/x"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("")
    folder = tmp_path / "build" / "one" / "firmware"
    (folder / "pixstep-one.map").write_text(MAP)
    (folder / "pixstep-one.elf").write_bytes(b"\x7fELF\0\x80GCC: (GNU) 5.4.0\0more\0")
    return tmp_path


def test_objects_are_named_by_their_modules(root):
    found = module_sizes.measure(["one"], root)
    assert found.compiler == "5.4.0"
    assert found.sizes["app/data"] == {"one": Bytes(0x33, 0x17)}
    assert set(found.sizes) == {"app/data", "gaps", "avr/hal/isr", "libgcc", "start-up code"}


def test_two_sources_of_one_name_are_refused(root):
    (root / "firmware" / "avr" / "hal" / "data.c").write_text("")
    with pytest.raises(MapError, match=r"two sources are called data\.c"):
        module_sizes.measure(["one"], root)


def test_an_image_that_was_not_built_is_refused(root):
    with pytest.raises(MapError, match="build it first"):
        module_sizes.measure(["one", "two"], root)


def record(compiler="5.4.0", **sizes):
    """Return a record of two boards with the given modules: (flash, RAM) for each, or None."""
    boards = ["uno", "mega"]
    found = {
        name: {board: Bytes(*one) for board, one in zip(boards, pair, strict=True) if one}
        for name, pair in sizes.items()
    }
    return module_sizes.Record(compiler, boards, found)


LINES = record(seek=((100, 5), (200, 9)), events=(None, (40, 0)), gaps=((1, 0), None))


def test_the_table_says_what_was_measured():
    text = markdown.marked(module_sizes.TABLE, module_sizes.table(LINES))
    assert module_sizes.parse(text) == LINES
    assert "| `events` | - | - | 40 | 0 |" in text
    assert "| all | 101 | 5 | 240 | 9 |" in text


@pytest.mark.parametrize(
    ("now", "found"),
    [
        (record(seek=((116, 5), (10, 0)), events=(None, (40, 0))), []),
        (
            record(seek=((117, 5), (200, 9)), events=(None, (40, 0))),
            ["uno: seek: 117 bytes of flash, its line is 100"],
        ),
        (
            record(seek=((100, 5), (200, 10)), events=(None, (40, 0)), gaps=(None, (3, 0))),
            ["mega: seek: 10 bytes of RAM, its line is 9"],
        ),
        (
            record(seek=((100, 5), (200, 9)), events=((2, 0), None)),
            ["uno: events has no line", "mega: events has a line and no code"],
        ),
    ],
)
def test_a_module_past_its_line_is_found(now, found):
    assert module_sizes.past_lines(now, LINES) == found


def test_a_board_without_a_table_and_a_table_without_a_board_are_found():
    now = module_sizes.Record("5.4.0", ["mega", "third"], {"seek": {"mega": Bytes(200, 9)}})
    lines = record(seek=((100, 5), (200, 9)))
    assert module_sizes.past_lines(now, lines) == [
        "third: the table does not have this board",
        "uno: the table has it, firmware/avr/boards has not",
    ]


def test_what_grew_is_renewed_by_one_command(tmp_path, capsys):
    path = tmp_path / "TIMING.md"
    path.write_text(markdown.marked(module_sizes.TABLE, module_sizes.table(LINES)))
    grown = record(seek=((150, 5), (200, 9)), events=(None, (40, 0)))
    problems = module_sizes.judge(grown, path)
    assert problems[0] == "uno: seek: 150 bytes of flash, its line is 100"
    assert problems[-1].endswith(f"module_sizes.py --write {path}")
    markdown.write(path, module_sizes.TABLE, module_sizes.table(grown))
    assert module_sizes.judge(grown, path) == []
    other = record("14.2.0", seek=((900, 5), (200, 9)), events=(None, (40, 0)))
    assert module_sizes.judge(other, path) == []
    assert "not compared" in capsys.readouterr().out


def test_a_document_without_the_table_is_refused(tmp_path):
    path = tmp_path / "TIMING.md"
    path.write_text("# Timing\n")
    with pytest.raises(MapError, match=r"TIMING\.md: no table"):
        module_sizes.judge(LINES, path)


FLASH, RAM = Section(True, False), Section(False, True)
IMAGE = """\
00000100 00000020 T seek_poll
00000120 00000030 t look.lto_priv.4
00000150 00000008 t look.constprop.1
00000158 00000004 t table.1234
00000200 00000010 T in_another_object
00800100 00000006 b seek
         U missing
"""


def defined(**modules):
    """Return the owners of names: symbols of each module as (name, length)."""
    return whole_program.owners(
        (module, [whole_program.Symbol(0, size, name) for name, size in symbols])
        for module, symbols in modules.items()
    )


OWNERS = defined(
    seek=[("seek_poll", 0x40), ("look", 0x31), ("seek", 6), ("table", 4)], inputs=[("look", 9)]
)
PARTS = [Part(0x100, 0x60, FLASH), Part(0x800100, 8, RAM)]


def test_symbols_of_the_whole_program_belong_to_their_modules():
    found = whole_program.by_module(PARTS, whole_program.parse_symbols(IMAGE), OWNERS)
    assert found == {
        "seek": Bytes(0x20 + 0x30 + 4, 6),
        "inputs": Bytes(8, 0),
        "shared": Bytes(4, 2),
    }


def test_a_copy_of_a_function_belongs_to_its_module_too():
    symbols = [whole_program.Symbol(at, size, "look") for at, size in ((0, 9), (16, 48), (64, 8))]
    assert whole_program.assign(symbols, OWNERS["look"]) == ["inputs", "seek", "inputs"]


def test_symbols_longer_than_their_object_are_refused():
    symbols = [whole_program.Symbol(0x100, 0x60, "look"), whole_program.Symbol(0x110, 8, "seek")]
    with pytest.raises(MapError, match="longer"):
        whole_program.by_module(PARTS[:1], symbols, OWNERS)


def test_the_linkers_own_object_is_the_whole_program():
    """Its name in the map is another one in every build."""
    lines = MAP.replace("firmware/libapp.a(data.c.obj)", "/tmp/ccxkYlw2.ltrans0.ltrans.o")
    image = map_file.read_map(lines)
    assert image.objects[map_file.WHOLE_PROGRAM] == Bytes(0x33, 0x17)
    assert [(part.at, part.size) for part in image.whole] == [
        (0x10, 7), (0x18, 0x28), (0x800100, 4), (0x800104, 0x13),
    ]  # fmt: skip

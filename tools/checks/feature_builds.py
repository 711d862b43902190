# SPDX-License-Identifier: MIT
"""Images with one feature switch turned over, made from a board's build: only what the switch
changes is compiled again, with the build's own commands, and linked with the rest of its objects.

An object whose preprocessed source is as it was the last time is not compiled again, and an image
of the same objects is not linked again.
"""

import hashlib
import json
import re
import shlex
import subprocess
from dataclasses import dataclass
from pathlib import Path

from modules import object_of

# Whatever the part's flash: an image that does not fit is measured all the same.
LARGE_FLASH = "-Wl,--defsym=__TEXT_REGION_LENGTH__=0x100000"
LAYOUT = (
    "firmware/pixstep_layout/layout.h"  # what the assembly knows of structs: cmake/layout.cmake
)
DEPENDENCY_OPTIONS = {"-MT", "-MF", "-o"}  # each with a word behind it
LINE_MARKER = re.compile(r'^# \d+ "([^"<]+)"', re.MULTILINE)
ALL_SWITCHES = "FEATURES_BITS"  # the macro that depends on every switch
TABLE_OF_SWITCHES = "build_features.h"  # names each switch and depends on none of them, but for
NEEDED_BY = {"FEATURE_TOKENS": "FEATURE_GATE"}  # switches that turn another one off


class BuildError(Exception):
    """An image that could not be built; the message has the compiler's words."""


@dataclass(frozen=True)
class Compilation:
    """How a build makes one object."""

    source: Path
    made: str  # the object, as the link command names it
    words: tuple[str, ...]  # the compiler's command without the object and dependency files


@dataclass(frozen=True)
class Build:
    """A board's finished build: its folder, how it makes each object of the image, how it links."""

    folder: Path
    compilations: tuple[Compilation, ...]
    link: tuple[str, ...]
    layout: tuple[tuple[str, ...], ...]  # the commands that make LAYOUT


def run(words: list[str], folder: Path) -> str:
    """Output of a compiler or linker, which has to be silent otherwise; BuildError if it is not."""
    done = subprocess.run(words, cwd=folder, capture_output=True, check=False, text=True)
    if done.returncode or done.stderr.strip():
        said = (done.stderr or done.stdout).splitlines()
        named = [line for line in said if re.search("error|warning|undefined", line)] or said[-3:]
        raise BuildError("; ".join(named[:3]) or f"{words[0]} failed")
    return done.stdout


def plain_words(command: str) -> tuple[str, ...]:
    """A compile command without the names of what it writes."""
    kept, skip = [], False
    for word in shlex.split(command):
        if not skip and word not in DEPENDENCY_OPTIONS | {"-MD", "-c"}:
            kept.append(word)
        skip = not skip and word in DEPENDENCY_OPTIONS
    return tuple(kept)


def read_link(folder: Path, image: str) -> tuple[str, ...]:
    """The command that links an image, without its map."""
    listed = run(["ninja", "-t", "commands", image], folder)
    for line in reversed(listed.splitlines()):
        for command in line.split(" && "):
            if f"-o firmware/{image}.elf" in command:
                words = shlex.split(command)
                return tuple(word for word in words if not word.startswith("-Wl,-Map="))
    raise BuildError(f"{folder}: does not say how it links {image}")


def read_layout(folder: Path) -> tuple[tuple[str, ...], ...]:
    """The commands that make the header of layouts: compile, then pick out."""
    listed = run(["ninja", "-t", "commands", LAYOUT], folder)
    commands = [line.split(" && ")[-1] for line in listed.splitlines()]
    return tuple(tuple(shlex.split(line)) for line in commands if "layout" in line)


def read_build(folder: Path, image: str) -> Build:
    """Read a configured and finished build."""
    try:
        listing = json.loads((folder / "compile_commands.json").read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise BuildError(f"{folder}: {error}: build it first") from None
    link = read_link(folder, image)
    linked = set(link)
    found = [
        Compilation(Path(entry["file"]), object_of(entry), plain_words(entry["command"]))
        for entry in listing
        if object_of(entry) in linked
    ]
    return Build(folder, tuple(found), link, read_layout(folder))


def code_of(text: str) -> str:
    """What the compiler sees of a preprocessed source: no line markers, no empty lines."""
    lines = (line.strip() for line in text.splitlines())
    return "\n".join(line for line in lines if line and not line.startswith("# "))


def defined(values: dict[str, int]) -> list[str]:
    """Options of the compiler that set the switches."""
    return [f"-D{switch}={value}" for switch, value in values.items()]


class Maker:
    """Makes the images of one build with a switch turned over, each in its own folder."""

    def __init__(self, build: Build, folder: Path) -> None:
        """Preprocess every source once, as the build does."""
        self.build = build
        self.folder = folder.resolve()
        self.usual: dict[str, str] = {}
        self.named: dict[str, str] = {}
        self.texts: dict[str, str] = {}
        for one in build.compilations:
            text = run([*one.words, "-E"], build.folder)
            self.usual[one.made] = code_of(text)
            self.named[one.made] = "\n".join(
                self.read(name) for name in sorted(set(LINE_MARKER.findall(text)))
            )

    def read(self, name: str) -> str:
        """The text of a source or header, but for the table of the switches' defaults."""
        if Path(name).name == TABLE_OF_SWITCHES:
            return ""
        if name not in self.texts:
            path = self.build.folder / name
            text = path.read_text(encoding="utf-8") if path.is_file() else ""
            self.texts[name] = text if "FEATURE" in text else ""
        return self.texts[name]

    def image(self, switch: str, value: int) -> Path:
        """The image with the switch set to a value; its ELF file."""
        return self.image_with({switch: value}, switch.lower())

    def image_with(self, values: dict[str, int], name: str) -> Path:
        """The image with these switches set, made in the folder of this name."""
        folder = self.folder / name
        folder.mkdir(parents=True, exist_ok=True)
        others = {}
        layout = self.layout(values, folder)
        for one in self.build.compilations:
            made = self.turned(one, values, folder, layout)
            if made:
                others[one.made] = str(made)
        if not others:
            raise BuildError("changes nothing that is compiled")
        return self.linked(others, folder)

    def layout(self, values: dict[str, int], folder: Path) -> Path:
        """The folder of the header of layouts with the switches set."""
        compiled, picked = map(list, self.build.layout)
        made = folder / "layout.s"
        words = [*plain_words(shlex.join(compiled)), *defined(values)]
        code = code_of(run([*words, "-E"], self.build.folder))
        self.once(made, code, [*words, "-o", str(made)])
        header = folder / "layout" / "layout.h"
        words = [f"-DTO={header}" if word.startswith("-DTO=") else word for word in picked]
        words = [f"-DFROM={made}" if word.startswith("-DFROM=") else word for word in words]
        run(words, self.build.folder)
        return header.parent

    def turned(
        self, one: Compilation, values: dict[str, int], folder: Path, layout: Path
    ) -> Path | None:
        """The object with the switches set, or None if it is the build's own."""
        names = self.named[one.made]
        too = [NEEDED_BY[switch] for switch in values if switch in NEEDED_BY]
        assembly = one.source.suffix == ".S"
        if not assembly and not any(s in names for s in (*values, *too, ALL_SWITCHES)):
            return None
        words = [*one.words, *defined(values)]
        if assembly:
            words.insert(1, f"-I{layout}")
        code = code_of(run([*words, "-E"], self.build.folder))
        if code == self.usual[one.made]:
            return None
        made = folder / f"{one.source.name}.o"
        self.once(made, code, [*words, "-c", "-o", str(made)])
        return made

    def linked(self, others: dict[str, str], folder: Path) -> Path:
        """Link the build's objects, some of them replaced by others."""
        made = folder / "image.elf"
        words = [others.get(word, word) for word in self.build.link]
        words[words.index("-o") + 1] = str(made)
        objects = [
            self.build.folder / others.get(one.made, one.made) for one in self.build.compilations
        ]
        sums = "".join(hashlib.sha256(path.read_bytes()).hexdigest() for path in objects)
        self.once(made, sums, [*words, LARGE_FLASH])
        return made

    def once(self, made: Path, content: str, words: list[str]) -> None:
        """Run a command unless its result is there, made of the same by the same command."""
        key = hashlib.sha256("\0".join([content, *words]).encode()).hexdigest()
        note = made.with_name(f"{made.name}.key")
        if made.is_file() and note.is_file() and note.read_text(encoding="ascii") == key:
            return
        note.unlink(missing_ok=True)
        run(words, self.build.folder)
        note.write_text(key, encoding="ascii")

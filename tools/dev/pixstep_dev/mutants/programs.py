# SPDX-License-Identifier: MIT
"""What is built from the firmware, object by object, and how to build a part of it again.

Compiler commands and dependencies are those of the builds that are there (build/host, build/uno,
build/mega), as ninja knows them. A workshop builds changed objects and what is linked from them in
a folder of its own; nothing is written anywhere else.
"""

import json
import os
import re
import shlex
import subprocess
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from pixstep import natives
from pixstep.errors import UserError

_CHANGEABLE = re.compile(r"libpixstep_\w+\.a$")  # archives whose members are linked by name
_MEMBER = re.compile(r"(?P<archive>[^\s(]+\.a)\((?P<name>[^)]+)\)")  # begins a line of a linker map
_CACHE = "ccache"  # before the compiler, where CMake was told to launch it so
_NO_DEBUG = ("-g0", "-w")  # line numbers of the debugger's are not what a program does


def call(command: list[str], cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run a program and keep its text."""
    return subprocess.run(
        command, cwd=cwd, capture_output=True, text=True, check=False, errors="replace"
    )


def _output(command: list[str], cwd: Path) -> str:
    done = call(command, cwd)
    if done.returncode:
        raise UserError(f"{shlex.join(command)}: {done.stderr.strip() or done.stdout.strip()}")
    return done.stdout


def _without_deps(words: list[str]) -> list[str]:
    """Return a compiler's command that notes nowhere what it has read, without a cache of it."""
    cached = Path(words[0]).name == _CACHE
    kept = [word for word in words[cached:] if word != "-MD"]
    for option in ("-MT", "-MF"):
        if option in kept:
            at = kept.index(option)
            del kept[at : at + 2]
    return kept


@dataclass(frozen=True)
class BuiltProgram:
    """A program of a build: its link command, and the objects that it takes, by their paths."""

    build: "Build"
    target: str
    words: tuple[str, ...]
    objects: tuple[str, ...]


@dataclass
class Build:
    """One of the builds under build/."""

    name: str
    deps: dict[str, set[str]] = field(default_factory=dict)  # object: sources and headers
    commands: dict[str, list[str]] = field(default_factory=dict)  # object: how it is compiled
    programs: dict[str, BuiltProgram] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not (self.folder / "build.ninja").is_file():
            raise UserError(f"{self.folder}: not built: run `cmake --workflow --preset default`")
        for entry in json.loads(_output(["ninja", "-t", "compdb"], self.folder)):
            if entry["output"].endswith((".o", ".obj")):
                self.commands[entry["output"]] = _without_deps(shlex.split(entry["command"]))
        found: set[str] = set()
        for line in _output(["ninja", "-t", "deps"], self.folder).splitlines():
            if ": #deps" in line:
                found = set()
                self.deps[line.split(":")[0]] = found  # filled by the lines that follow
            elif line.strip():
                # A compiler's cache names files by where they are from here.
                found.add(os.path.normpath(self.folder / line.strip()))

    @cached_property
    def folder(self) -> Path:
        """Return the folder that it was built in."""
        return natives.root() / "build" / self.name

    def stale(self) -> list[str]:
        """Return the objects that are older than what they are made of."""
        return [
            name
            for name in self.commands
            if (made := self.folder / name).is_file()
            and any(
                Path(source).stat().st_mtime > made.stat().st_mtime
                for source in self.deps.get(name, ())
                if Path(source).is_file()
            )
        ]

    def depending(self, file: Path) -> list[str]:
        """Return the objects that a file goes into."""
        return [name for name in self.commands if str(file) in self.deps.get(name, ())]

    def program(self, target: str) -> BuiltProgram:
        """Return a program of this build."""
        if target not in self.programs:
            self.programs[target] = self._program(target)
        return self.programs[target]

    def _program(self, target: str) -> BuiltProgram:
        text = _output(["ninja", "-t", "commands", target], self.folder).splitlines()[-1]
        link = next(part for part in text.split(" && ") if f" -o {target}" in part)
        words = shlex.split(link)
        traced = [word for word in words if not word.startswith("-Wl,-Map")]
        traced[traced.index("-o") + 1] = "/dev/null"
        objects = [word for word in words if word.endswith((".o", ".obj"))]
        for line in _output([*traced, "-Wl,-M"], self.folder).splitlines():
            member = _MEMBER.match(line)
            if member and _CHANGEABLE.search(member["archive"]):
                objects.append(self._of_archive(member["archive"], member["name"]))
        left_out = set(objects)
        kept = [
            word
            for word in words
            if word not in left_out
            and not _CHANGEABLE.search(word)
            and not word.startswith(("-Wl,-Map", "-Wl,--start-group", "-Wl,--end-group"))
        ]
        return BuiltProgram(self, target, tuple(kept), tuple(dict.fromkeys(objects)))

    def _of_archive(self, archive: str, member: str) -> str:
        path = Path(archive)
        name = path.stem.removeprefix("lib")
        # A layer's library is made of the objects of an object library, others of their own.
        folders = [path.parent / "CMakeFiles" / f"{name}{kind}.dir" for kind in ("_objects", "")]
        made = [
            str(place.relative_to(self.folder))
            for folder in folders
            for place in (self.folder / folder).rglob(member)
        ]
        found = [place for place in made if place in self.commands] or made
        if len(found) != 1:
            raise UserError(f"{archive}: {member} is not in one place of {folders[0].parent}")
        return found[0]


class CannotBuildError(Exception):
    """A changed source does not compile, or its program does not link."""


class Workshop:
    """A folder in which one changed file is built into programs."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._made: dict[tuple[str, str], Path] = {}
        self._file: Path | None = None

    def change(self, file: Path, text: str) -> None:
        """Begin with another change: `file` of the tree has this text."""
        self.restore()
        self._file = file
        place = self.folder / file.relative_to(natives.root())
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(text, encoding="utf-8")

    def restore(self) -> None:
        """Forget the change and what was made of it."""
        for made in self._made.values():
            made.unlink(missing_ok=True)
        self._made.clear()
        if self._file:
            (self.folder / self._file.relative_to(natives.root())).unlink(missing_ok=True)
        self._file = None

    def object(self, build: Build, name: str) -> Path:
        """Return the changed object of that name, compiled if it was not; CannotBuildError."""
        return self._object("objects", build, name, _NO_DEBUG)

    def code(self, build: Build, name: str) -> Path:
        """Return the like of `object` that holds machine code alone, to be compared.

        What link-time optimisation keeps in an object names the source's folder and columns and
        has names made by chance.
        """
        return self._object("code", build, name, (*_NO_DEBUG, "-fno-lto"))

    def _object(self, kind: str, build: Build, name: str, options: tuple[str, ...]) -> Path:
        key = f"{kind} of {build.name}", name
        if key not in self._made:
            made = self.folder / kind / build.name / name
            self._compile(build, name, made, options)
            self._made[key] = made
        return self._made[key]

    def _compile(self, build: Build, name: str, made: Path, options: tuple[str, ...]) -> None:
        """Compile with the changed file before the tree's."""
        root, mine = natives.root(), self.folder
        words = list(build.commands[name])
        words[words.index("-o") + 1] = str(made)
        source = Path(words[-1])
        if source == self._file:
            words[-1] = str(mine / source.relative_to(root))
        first = [f"-I{mine / part}" for part in ("firmware", "firmware/core", "host_tests")]
        made.parent.mkdir(parents=True, exist_ok=True)
        done = call([words[0], *first, *words[1:-1], *options, words[-1]], build.folder)
        if done.returncode:
            raise CannotBuildError(done.stderr.strip())

    def link(self, program: BuiltProgram) -> Path:
        """Return the program with the changed objects in it; CannotBuildError."""
        build = program.build
        key = build.name, program.target
        if key in self._made:
            return self._made[key]
        changed = set(build.depending(self._file)) if self._file else set()
        objects = [
            str(self.object(build, name)) if name in changed else name for name in program.objects
        ]
        made = self.folder / "build" / build.name / program.target
        made.parent.mkdir(parents=True, exist_ok=True)
        words = list(program.words)
        at = words.index("-o")
        words[at + 1] = str(made)
        done = call([*words[:at], *objects, *words[at:]], build.folder)
        if done.returncode:
            raise CannotBuildError(done.stderr.strip())
        self._made[key] = made
        return made

# SPDX-License-Identifier: MIT
"""What a mutant is tried by, from the quickest to the slowest: suites, explorer, tests on images.

A program is killed when it fails, crashes, or takes far more processor time than the unchanged one
did; before anything is tried, all of it has passed unchanged.
"""

import contextlib
import itertools
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from pixstep import natives
from pixstep.board import boards
from pixstep.errors import UserError
from pixstep_dev.mutants.programs import (
    Build,
    BuiltProgram,
    Workshop,
)

NAMES = ("native", "avr", "explore", "images")
BOARDS = boards.BOARD_NAMES
# Tests on the real images and on what else is made of the firmware, the quickest first; each file
# takes seconds.
IMAGE_TESTS = (
    "exact", "board_run", "board_stop", "board_trouble", "waiting_axes", "faults_provoked",
    "safety_faults", "seek_campaign", "board_settings", "starts", "pixel_rates", "captures",
)  # fmt: skip
# Tests that only survivors of these meet: the rest of the quick check that runs images.
MORE_IMAGE_TESTS = (
    "clock_input", "clock_boards", "line_divider", "direction", "seek_bounces", "shared_switch",
    "stop_heard", "gates", "clocks", "powercuts", "plays", "other_frequency", "witness", "estops",
    "switches", "parking", "homing_uno", "homing_mega", "time_check", "turns", "fast_moves",
    "bus", "lost_time", "lock_pixels", "orders", "orders_kept", "framestorm", "bad_line",
    "wild_counts", "linecheck", "records", "reversal_runs", "board_images", "one_check",
    "homings", "lock",
)  # fmt: skip
# Corpora of the fuzzers, played by the firmware beside a second implementation.
REPLAYS = {"replay server": "server", "replay board": "board"}
# What the Python tests run beside images: the host's own programs of the firmware.
HOST_PROGRAMS = ("python/_core.abi3.so", "bin/pixstep-native-board")
# For assembly before these: handlers beside their twins in C, of boards that have the test.
TWINS = ("handlers", "catch_up")
# And behind them: what meets the interrupts' rare ways.
ASSEMBLY_TESTS = ("late_interrupts",)
# The Uno's as the quick check has them; of two axes `explore_two` goes further.
EXPLORERS = {
    "explore": ("bin/pixstep-explore", ("--first", "--actions", "2", "--periods", "1")),
    "explore pins": (
        "bin/pixstep-explore",
        ("--first", "--actions", "1", "--periods", "1", "--pins", "1"),
    ),
    "explore periods": (
        "bin/pixstep-explore",
        ("--first", "--actions", "1", "--periods", "2"),
    ),
    "explore two": (
        "bin/pixstep-explore-two",
        ("--first", "--actions", "1", "--periods", "1", "--every", "8"),
    ),
}

# Suites on AVR that take longer are for mutants of the file that they are named after.
_AVR_SECONDS = 2.0
_SLOWER = 10  # so many times the unchanged run's time is no longer the machine's business
_LEAST_S = 1.0
_MEMORY_BYTES = 4 << 30  # a mutant may not take the machine with it
_NICE = 3
_OUT_OF_TIME = (-signal.SIGXCPU, -signal.SIGKILL)


# The name of each run of a stage, and the run: it takes its limit of processor time.
Runs = Iterator[tuple[str, Callable[[float | None], "StageVerdict"]]]
_running: set[subprocess.Popen[bytes]] = set()


@dataclass(frozen=True)
class StageVerdict:
    """What became of a mutant in a stage: `how` is empty if it was not killed."""

    how: str = ""
    by: str = ""
    seconds: float = 0  # of processor time

    def __bool__(self) -> bool:
        return bool(self.how)


@dataclass(frozen=True)
class _Ended:
    """How a program ended: status, text, seconds of processor time."""

    status: int
    text: str
    seconds: float


def c_sources() -> list[Path]:
    """Return the C files that may be changed: core and app."""
    firmware = natives.root() / "firmware"
    return sorted(path for part in ("core", "app") for path in (firmware / part).rglob("*.[ch]"))


def assembly_sources() -> list[Path]:
    """Return the assembly files, those of the hal too."""
    firmware = natives.root() / "firmware"
    return sorted(path for end in ("*.S", "*.inc") for path in firmware.rglob(end))


class Stages:
    """All that mutants are tried by, with the times that the unchanged programs take."""

    def __init__(self, names: tuple[str, ...] = NAMES, assembly: bool = False) -> None:
        self.names = names
        self._assembly = assembly
        self.builds = {name: Build(name) for name in ("host", *BOARDS)}
        self.seconds: dict[str, float] = {}
        self._kills: Counter[tuple[str, str]] = Counter()
        self._lock = threading.Lock()
        for build in self.builds.values():
            if stale := build.stale():
                raise UserError(f"{build.folder}: {stale[0]} is older than its source: build first")

    def suites(self, stage: str) -> list[BuiltProgram]:
        """Return the Unity suites of a stage."""
        build, pattern, end = {
            "native": (self.builds["host"], "bin/test_", ""),
            "avr": (self.builds["mega"], "host_tests/test_", ".elf"),
        }[stage]
        names = sorted(
            path.stem.removeprefix("test_")
            for path in (natives.root() / "host_tests").rglob("test_*.c")
        )
        # Some are there once more: with the core of a board with a single axis, at other addresses.
        more = [f"{name}_{kind}" for name in names for kind in ("one", "shifted")]
        names += [one for one in more if (build.folder / f"{pattern}{one}{end}").is_file()]
        return [build.program(f"{pattern}{name}{end}") for name in names]

    def measure(self, workshop: Workshop) -> Iterator[str]:
        """Run everything unchanged; yield the name of each; UserError if one fails.

        What is linked here is linked as a mutant is, so the way of linking is tried too.
        """
        for stage in self.names:
            for name, run in self._runs(stage, workshop, None):
                verdict = run(None)
                self.seconds[name] = verdict.seconds
                if verdict:
                    raise UserError(f"{name}: fails without any change: {verdict.by}")
                yield name
        workshop.restore()

    def equivalent(self, workshop: Workshop, plain: Workshop, file: Path) -> bool:
        """Whether a changed file makes the same object code natively and for every board."""
        for build in self.builds.values():
            for name in build.depending(file):
                if not name.startswith("firmware/"):
                    continue
                with self._lock:
                    before = plain.code(build, name)
                if workshop.code(build, name).read_bytes() != before.read_bytes():
                    return False
        return True

    def try_stage(self, stage: str, workshop: Workshop, file: Path) -> StageVerdict:
        """Try a changed file by a stage; CannotBuildError if it does not compile."""
        for name, run in self._runs(stage, workshop, file):
            verdict = run(_SLOWER * self.seconds.get(name, _LEAST_S) + _LEAST_S)
            if verdict:
                with self._lock:
                    self._kills[file.stem, name] += 1
                return verdict
        return StageVerdict()

    def _runs(self, stage: str, workshop: Workshop, file: Path | None) -> Runs:
        """Yield name and run of all that a stage has for a file; None: for every file."""
        if stage in ("native", "avr"):
            before = "build/host/bin/pixstep-sim --unit --board mega=" if stage == "avr" else ""
            yield from self._suite_runs(stage, workshop, file, before)
            if stage == "native":
                yield from self._replays(workshop, file)
        elif stage == "explore":
            yield from self._explorer_runs(workshop, file)
        else:
            yield from self._beside_twins(workshop, file)
            yield stage, lambda limit: self._run_images(workshop, limit, IMAGE_TESTS)
            yield "more images", lambda limit: self._run_images(workshop, limit, MORE_IMAGE_TESTS)
            if self._assembly:
                yield (
                    "images of assembly",
                    lambda limit: self._run_images(workshop, limit, ASSEMBLY_TESTS),
                )

    def _replays(self, workshop: Workshop, file: Path | None) -> Runs:
        """Yield the corpora of the fuzzers."""
        for name, target in REPLAYS.items():
            program = self.builds["host"].program(f"bin/fuzz-replay-{target}")
            corpus = str(natives.root() / "fuzz" / "corpus" / f"{target}.hex")
            if file is None or _uses(program, file):
                first, told = ["{}", corpus], f"native {name}"
                yield told, partial(_run_linked, workshop, program, told, first=first, last=())

    def _beside_twins(self, workshop: Workshop, file: Path | None) -> Runs:
        """Yield the handlers of each image beside their twins in C."""
        if not self._assembly:
            return
        for twin, board in itertools.product(TWINS, BOARDS):
            tester = natives.root() / f"build/host/bin/{twin}_test_{board}"
            image = self.builds[board].program(f"firmware/pixstep-{board}.elf")
            if tester.is_file() and (file is None or _uses(image, file)):
                name = f"images {twin} {board}"
                first = [str(tester), "{}"]
                yield name, partial(_run_linked, workshop, image, name, first=first, last=())

    def _explorer_runs(self, workshop: Workshop, file: Path | None) -> Runs:
        for name, (target, limits) in EXPLORERS.items():
            program = self.builds["host"].program(target)
            if file is None or _uses(program, file):
                yield name, partial(_run_linked, workshop, program, name, first=[], last=limits)

    def _suite_runs(self, stage: str, workshop: Workshop, file: Path | None, before: str) -> Runs:
        simulator = str(natives.root() / "build/host/bin/pixstep-sim")
        first = [simulator, "--unit", "--board", "mega={}"] if before else ["{}"]
        programs = [one for one in self.suites(stage) if file is None or _uses(one, file)]
        named = [(f"{stage} {Path(one.target).stem.removeprefix('test_')}", one)
                 for one in programs]  # fmt: skip
        if file is not None:
            named = [pair for pair in named if self._worth(stage, file, pair[0])]
            named.sort(key=lambda pair: self._rank(file, pair[0]))
        for name, one in named:
            yield name, partial(_run_linked, workshop, one, name, first=first, last=())

    def _rank(self, file: Path, name: str) -> tuple[int, bool, float]:
        """Order suites: those that killed the file's mutants before, its own, the quick ones."""
        own = _is_own(file, name)
        return -self._kills[file.stem, name], not own, self.seconds.get(name, 0)

    def _worth(self, stage: str, file: Path, name: str) -> bool:
        quick = self.seconds.get(name, 0) < _AVR_SECONDS
        return stage == "native" or quick or _is_own(file, name)

    def _run_images(
        self, workshop: Workshop, limit: float | None, tests: tuple[str, ...]
    ) -> StageVerdict:
        """Run the Python tests on what is made of the firmware, in a folder like the tree."""
        root = _lookalike(workshop.folder / "tree")
        host = [self.builds["host"].program(target) for target in HOST_PROGRAMS]
        images = [self.builds[name].program(f"firmware/pixstep-{name}.elf") for name in BOARDS]
        for program in host + images:
            made = root / "build" / program.build.name / program.target
            made.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(workshop.link(program), made)
        tree = natives.root()
        files = [str(_test_file(tree, name)) for name in tests]
        command = [
            sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider",
            "-c", str(tree / "tools" / "pyproject.toml"), "--basetemp", str(root / "scratch"),
            *files,
        ]  # fmt: skip
        environment = {"PIXSTEP_ROOT": str(root), "PIXSTEP_REQUIRE_BUILT": "1"}
        done = _limited(command, limit, tree, environment)
        if done.status in _OUT_OF_TIME:
            return StageVerdict("timeout", "images")
        if done.status == 0:
            return StageVerdict(seconds=done.seconds)
        failed = [line for line in done.text.splitlines() if line.startswith(("FAILED", "ERROR"))]
        return StageVerdict(
            "images", failed[0].split(" - ")[0].split("/")[-1] if failed else "crash"
        )


def _test_file(tree: Path, name: str) -> Path:
    """Return the product's test of that name, or else the proof's."""
    found = tree / "tools" / "tests" / f"test_{name}.py"
    return found if found.is_file() else tree / "tools" / "dev" / "tests" / found.name


def _is_own(file: Path, name: str) -> bool:
    suite = name.split()[1]
    return suite in file.stem or file.stem in suite


def _uses(program: BuiltProgram, file: Path) -> bool:
    depending = set(program.build.depending(file))
    return any(name in depending for name in program.objects)


def _run_linked(
    workshop: Workshop,
    program: BuiltProgram,
    name: str,
    limit: float | None,
    first: list[str],
    last: tuple[str, ...],
) -> StageVerdict:
    """Link a program and run it."""
    made = str(workshop.link(program))
    command = [*[word.format(made) for word in first or ["{}"]], *last]
    done = _limited(command, limit, natives.root())
    if done.status == 0:
        return StageVerdict(seconds=done.seconds)
    return StageVerdict("timeout" if done.status in _OUT_OF_TIME else name.split()[0], name)


def _limited(
    command: list[str], seconds: float | None, cwd: Path, environment: dict[str, str] | None = None
) -> _Ended:
    """Run a command, nice, with limits of processor time and memory for each of its processes."""
    limits = []
    if seconds:
        limits = [f"--cpu={int(seconds) + 1}:{int(seconds) + 3}"]
    words = ["prlimit", f"--as={_MEMORY_BYTES}", "--core=0", *limits, "nice", "-n", str(_NICE)]
    with tempfile.TemporaryFile(mode="w+", errors="replace") as text:
        process = subprocess.Popen(
            [*words, *command],
            cwd=cwd,
            stdin=subprocess.DEVNULL,
            stdout=text,
            stderr=subprocess.STDOUT,
            env={**os.environ, **(environment or {})},
            start_new_session=True,
        )
        _running.add(process)
        try:
            _, status, usage = os.wait4(process.pid, 0)
        finally:
            _running.discard(process)
        process.returncode = os.waitstatus_to_exitcode(status)
        text.seek(0)
        return _Ended(process.returncode, text.read(), usage.ru_utime + usage.ru_stime)


def end() -> None:
    """End every program that runs, with what it has begun itself."""
    for process in list(_running):
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)


def _lookalike(folder: Path) -> Path:
    """Make a folder of links to the tree's files, with room for other images in it."""
    tree = natives.root()
    if not folder.is_dir():
        _link_all(tree, folder, ("build", ".git"))
        _link_all(tree / "build", folder / "build", (*BOARDS, "host", "mutants"))
        host = tree / "build" / "host"
        _link_all(host, folder / "build" / "host", ("bin", "python"))
        for part in ("bin", "python"):
            but = tuple(Path(target).name for target in HOST_PROGRAMS)
            _link_all(host / part, folder / "build" / "host" / part, but)
        for board in BOARDS:
            _link_all(tree / "build" / board, folder / "build" / board, ("firmware",))
    return folder


def _link_all(tree: Path, folder: Path, but: tuple[str, ...]) -> None:
    folder.mkdir(parents=True)
    for part in tree.iterdir():
        if part.name not in but:
            (folder / part.name).symlink_to(part)

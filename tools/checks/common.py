# SPDX-License-Identifier: MIT
"""What the rules share: the repository's files, and how a rule ends."""

import argparse
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def repository_files(root: Path = ROOT) -> list[Path]:
    """All files that are, or could be, committed; without git all outside of build folders."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"]
    try:
        listed = subprocess.run(command, cwd=root, capture_output=True, check=True, text=True)
        paths = [root / name for name in listed.stdout.split("\0") if name]
    except (OSError, subprocess.CalledProcessError):
        skipped = {"build", ".git", "__pycache__", "node_modules"}
        paths = [p for p in root.rglob("*") if not skipped & set(p.relative_to(root).parts)]
    return sorted(path for path in set(paths) if path.is_file())


def board_names(root: Path = ROOT) -> list[str]:
    """The boards: those with a file in firmware/avr/boards, by their BOARD_ID, then by name."""

    def place(file: Path) -> tuple[int, str]:
        number = re.search(r"^#define BOARD_ID\s+(\d+)", file.read_text(encoding="utf-8"), re.M)
        return (int(number[1]) if number else 1 << 16, file.stem)

    return [file.stem for file in sorted((root / "firmware/avr/boards").glob("*.def"), key=place)]


def build_folder(board: str, root: Path = ROOT) -> Path:
    """Where a board's build is."""
    return root / "build" / board


def table_options(about: str, *flags: str) -> argparse.Namespace:
    """Read the command line of a rule that keeps a table in a document: `check`, `write`."""
    parser = argparse.ArgumentParser(description=about)
    parser.add_argument("--check", type=Path, metavar="FILE", help="compare with the table in FILE")
    parser.add_argument("--write", type=Path, metavar="FILE", help="rewrite the table in FILE")
    for flag in flags:
        parser.add_argument(flag, action="store_true")
    return parser.parse_args()


def finish(rule: str, looked_at: str, problems: list[str]) -> None:
    """Print the problems, one a line, and a closing line; exit 1 if there are any."""
    for problem in problems:
        print(problem)
    print(f"{rule}: {looked_at}, {len(problems)} problem{'' if len(problems) == 1 else 's'}")
    sys.exit(1 if problems else 0)

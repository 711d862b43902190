# SPDX-License-Identifier: MIT
"""What the rules share: the repository's files, and how a rule ends."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def repository_files() -> list[Path]:
    """All files that are, or could be, committed; without git all outside of build folders."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"]
    try:
        listed = subprocess.run(command, cwd=ROOT, capture_output=True, check=True, text=True)
        paths = [ROOT / name for name in listed.stdout.split("\0") if name]
    except (OSError, subprocess.CalledProcessError):
        skipped = {"build", ".git", "__pycache__", "node_modules"}
        paths = [p for p in ROOT.rglob("*") if not skipped & set(p.relative_to(ROOT).parts)]
    return sorted(path for path in set(paths) if path.is_file())


def finish(rule: str, looked_at: str, problems: list[str]) -> None:
    """Print the problems, one a line, and a closing line; exit 1 if there are any."""
    for problem in problems:
        print(problem)
    print(f"{rule}: {looked_at}, {len(problems)} problem{'' if len(problems) == 1 else 's'}")
    sys.exit(1 if problems else 0)

# SPDX-License-Identifier: MIT
"""Convert a folder of the printer's files, CSV to CSB: python convert_folder.py FROM TO"""

import sys
from pathlib import Path

import pixstep as px

folder, out = map(Path, sys.argv[1:])
out.mkdir(exist_ok=True)
for source in sorted(folder.glob("*.[cC][sS][vV]")):
    try:
        print(px.convert_file(source, out / f"{source.stem}.CSB"))
    except px.PlainError as error:
        print(f"left out: {error}")

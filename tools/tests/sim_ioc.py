# SPDX-License-Identifier: MIT
"""`pixstep ioc --simulate` that notes edges and states: python sim_ioc.py FOLDER ioc --simulate ...

FOLDER/edges.csv has every edge of the boards; FOLDER/dmov.csv each change of DMOV: the record, the
value, the simulated time and the raw position.
"""

import sys
from dataclasses import replace
from pathlib import Path

from pixstep.__main__ import run
from pixstep.ioc.channels import FieldChannel
from pixstep.operations import ioc

if __name__ == "__main__":
    place = Path(sys.argv.pop(1))
    options, post = ioc.sim_options, FieldChannel.post
    states = (place / "dmov.csv").open("w")

    async def noted(self, value, time_s):
        """Note a change of DMOV, then post it."""
        if self.field.name == "DMOV":
            motor = self._owner
            now_s = motor._drive._owner.now_s()
            states.write(f"{motor.name},{value},{now_s:.9f},{motor.record['RRBV']}\n")
            states.flush()
        await post(self, value, time_s)

    ioc.sim_options = lambda machine: replace(options(machine), edges=place / "edges.csv")
    FieldChannel.post = noted
    run()

# SPDX-License-Identifier: MIT
"""A job is simulated by the workers of a Dask cluster; one that is not the same is named."""

import shutil

import pytest

from pixstep import natives, ops
from pixstep.errors import UserError
from pixstep_dev.jobs.cluster import Cluster
from pixstep_dev.jobs.press import Press


@pytest.mark.usefixtures("simulator")
def test_workers_give_the_same_rows_and_another_one_is_named(tmp_path):
    job = Press.make(tmp_path, 4, pixels=4).job
    here = ops.job_simulate(job.path, out=tmp_path / "here", block=2, processes=1)
    cluster = Cluster(tmp_path, 0)
    with cluster.up() as relay:

        def simulate(out):
            return ops.job_simulate(
                job.path, out=tmp_path / out, edges=tmp_path / "edges", block=2,
                scheduler=relay.address,
            )  # fmt: skip

        with pytest.raises(UserError, match="has no workers"):
            simulate("nobody")
        cluster.add()
        cluster.await_workers()
        there = simulate("there")
        assert (there["verdict"], there["simulated"]) == ("pass", 2)
        assert there["sha256"] == here["sha256"] and relay.bytes > 0
        assert len([*(tmp_path / "edges").glob("*.parquet")]) == 2
        cluster.add(PIXSTEP_SIM=str(another_simulator(tmp_path)))
        cluster.await_workers()
        with pytest.raises(UserError, match=r"worker w1 at tcp://.*: pixstep-sim \w+ instead of"):
            simulate("refused")
    assert not (tmp_path / "refused").exists()
    again = ops.job_simulate(job.path, out=tmp_path / "there", block=2, scheduler="nowhere")
    assert (again["simulated"], again["known"]) == (0, 2)  # nobody has to be asked


def another_simulator(folder):
    """Return a copy of the simulator that is not the same, byte for byte."""
    other = folder / "pixstep-sim"
    shutil.copy(natives.program("pixstep-sim"), other)
    with other.open("ab") as file:
        file.write(b"\n")
    return other

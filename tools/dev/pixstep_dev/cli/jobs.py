# SPDX-License-Identifier: MIT
"""`pixstep-dev jobs`: campaigns of print jobs in simulated time, judged by their edges."""

from __future__ import annotations

from dataclasses import asdict

import click

from pixstep import progress
from pixstep.cli.command import Group
from pixstep_dev.cli.findings import finish, json_option, seed_option


@click.group("jobs", cls=Group)
def jobs_group() -> None:
    """What may happen to a print job: seams, late lines, dead hosts, lost or strange boards."""


@jobs_group.command()
@click.option("--times", type=click.IntRange(min=1), default=10, show_default=True, help="Kills.")
@click.option("--lines", type=click.IntRange(min=2), default=20, show_default=True)
@seed_option
@json_option
@click.pass_context
def kill(ctx: click.Context, times: int, lines: int, seed: int, as_json: bool) -> None:
    """Kill the host at random, also while it writes its log, and resume.

    Exit status 0 only if each line was printed exactly once by its edges, or was listed as broken
    or unknown beforehand.
    """
    from pixstep_dev.jobs import kill as campaign  # takes a while to load

    with progress.shown(f"{times} kills") as show:
        outcome = campaign.run(campaign.KillPlan(times, lines, seed), show)
    fates = ", ".join(f"{count} {name}" for name, count in sorted(outcome.fates.items()))
    rows = [
        f"{outcome.times} runs of {lines} lines, the host killed in {outcome.killed}, "
        f"the next one too in {outcome.killed_again}",
        f"  {outcome.listed} lines listed, at most {outcome.most_listed} of a run; of lines in "
        f"flight: {fates or 'none asked about'}",
    ]
    finish(ctx, asdict(outcome), rows, "every other line was printed once", as_json=as_json)


@jobs_group.command()
@click.option("--times", type=click.IntRange(min=1), default=6, show_default=True, help="Losses.")
@click.option("--lines", type=click.IntRange(min=2), default=10, show_default=True)
@seed_option
@json_option
@click.pass_context
def power(ctx: click.Context, times: int, lines: int, seed: int, as_json: bool) -> None:
    """Take a board's supply, reset it or cut its cable, and resume.

    Exit status 0 only if the board was named within a second, the others ended at the same line, at
    most two lines were unknown, and lines began within a step of their place.
    """
    from pixstep_dev.jobs import power as campaign  # takes a while to load

    with progress.shown(f"{times} losses") as show:
        outcome = campaign.run(campaign.PowerPlan(times, lines, seed), show)
    kinds = ", ".join(f"{count} {name}" for name, count in outcome.kinds.items())
    rows = [
        f"{outcome.times} losses of a board ({kinds}), named within {outcome.slowest_s:.2f} s",
        f"  {outcome.unknown} lines unknown, at most {outcome.most_unknown} of a run, "
        f"{outcome.broken} broken; {outcome.chains} chains of lines began at most "
        f"{outcome.worst_start_steps} steps off",
    ]
    finish(ctx, asdict(outcome), rows, "each was named, homed and went on", as_json=as_json)


@jobs_group.command()
@click.option("--times", type=click.IntRange(min=1), default=10, show_default=True, help="Delays.")
@click.option("--lines", type=click.IntRange(min=2), default=4, show_default=True)
@seed_option
@json_option
@click.pass_context
def late(ctx: click.Context, times: int, lines: int, seed: int, as_json: bool) -> None:
    """Let a line reach the queue of an axis, or of a board, too late.

    Exit status 0 only if all axes ended at the same line, by their edges, or a fault named a motor.
    """
    from pixstep_dev.jobs import late as campaign  # takes a while to load

    with progress.shown(f"{times} delays") as show:
        outcome = campaign.run(campaign.LatePlan(times, lines, seed), show)
    ends = ", ".join(f"{count} {name}" for name, count in sorted(outcome.ends.items()))
    rows = [f"{outcome.times} late lines: {ends}"]
    finish(ctx, asdict(outcome), rows, "none was silent", as_json=as_json)


@jobs_group.command()
@click.option("--lines", type=click.IntRange(min=2), default=20, show_default=True)
@click.option("--ppm", type=float, default=300.0, show_default=True, help="The clock is off by so.")
@click.option("--jitter", "jitter_us", type=float, default=5.0, show_default=True, help="In us.")
@click.option("--sync", type=click.Choice(["lock", "start"]), default="lock", show_default=True)
@seed_option
@json_option
@click.pass_context
def seams(
    ctx: click.Context, lines: int, ppm: float, jitter_us: float, sync: str, seed: int,
    as_json: bool,
) -> None:  # fmt: skip
    """Measure the seams between the lines of a job, on the pins.

    Exit status 0 only if there is no gap, the boards' edges are within 2 ticks, the steps within a
    tick of their board's grid, the load within a step at each image pixel both ways, and nothing
    drifts.
    """
    from pixstep_dev.jobs import seams as campaign  # takes a while to load

    plan = campaign.SeamsPlan(lines, ppm, jitter_us, -ppm, sync, seed)
    with progress.shown(f"{lines} lines") as show:
        outcome = campaign.run(plan, show)
    rows = [
        f"{lines} lines of 3 motors on 2 boards, sync {sync}, clock {ppm:+g} ppm, jitter "
        f"{jitter_us:g} us, the second oscillator {-ppm:+g} ppm",
        f"  gap {outcome.gap_px:g} px; boards' edges {outcome.apart_ticks:g} ticks apart; steps "
        f"{outcome.grid_ticks:.2f} ticks off their board's grid; drift "
        f"{outcome.drift_ticks:.2f} ticks",
        f"  load {outcome.load_steps} steps off at {outcome.load_pixels} image edges; grid "
        f"{outcome.clock_ticks:.1f} ticks beside the true clock's edges",
    ]
    finish(ctx, asdict(outcome), rows, "no seam shows", as_json=as_json)


@jobs_group.command()
@click.option("--lines", type=click.IntRange(min=8), default=64, show_default=True)
@click.option("--block", type=click.IntRange(min=1), default=8, show_default=True)
@click.option(
    "--memory-lines", type=click.IntRange(min=1), multiple=True, default=(100, 1000),
    show_default=True, help="Lines of a job in which the client's memory is measured.",
)  # fmt: skip
@seed_option
@json_option
@click.pass_context
def simulate(
    ctx: click.Context, lines: int, block: int, memory_lines: tuple[int, ...], seed: int,
    as_json: bool,
) -> None:  # fmt: skip
    """Simulate a job on one core, on two, on a cluster.

    Exit status 0 only if the rows are the same each time, also with a worker or a process killed
    and after an interruption; if less than 2 kB a line went between client and scheduler; and if
    the client's memory is the same for any number of lines.
    """
    from pixstep_dev.jobs import simulate as campaign  # takes a while to load

    with progress.shown(f"{lines} lines") as show:
        plan = campaign.JobSimulatePlan(lines, block, memory_lines, seed=seed)
        outcome = campaign.run(plan, show)
    rows = [
        f"{one.name}: {one.seconds:.1f} s, {one.simulated} blocks simulated, {one.known} known, "
        f"{one.repeated} again; rows {one.sha256[:12]}"
        for one in outcome.passes
    ]
    rows.append(f"{outcome.bytes_a_line:.0f} bytes a line between client and scheduler")
    rows += [
        f"client's memory for {count} equal lines ({outcome.different[count]} different blocks): "
        f"{memory:.1f} MB"
        for count, memory in outcome.memory_mb.items()
    ]
    finish(ctx, asdict(outcome), rows, "the same rows each time", as_json=as_json)


@jobs_group.command("plant-seam")
@click.option("--times", type=click.IntRange(min=0), default=4, show_default=True, help="Lines.")
@click.option("--lines", type=click.IntRange(min=6), default=12, show_default=True)
@seed_option
@json_option
@click.pass_context
def plant_seam(ctx: click.Context, times: int, lines: int, seed: int, as_json: bool) -> None:
    """Plant faults at seams: blocks have to find them.

    Lines that take play up wrongly, firmware whose grid loses a part of a tick. Exit status 0 only
    if simulated blocks find each at its seam, lines simulated alone find none, and nothing is found
    where nothing was planted.
    """
    from pixstep_dev.jobs import plant_seam as campaign  # takes a while to load

    with progress.shown(f"{times} faults") as show:
        outcome = campaign.run(campaign.PlantSeamPlan(times, lines, seed), show)
    rows = [
        f"{one.what} at line {one.line}: blocks find {len(one.in_blocks)} lines from "
        f"{min(one.in_blocks, default=0)} on, lines alone {len(one.alone)}\n  {one.reason}"
        for one in outcome.plants
    ]
    finish(ctx, asdict(outcome), rows, "blocks find each, lines alone none", as_json=as_json)


@jobs_group.command()
@click.option("--pairs", type=click.IntRange(min=1), help="So many, by chance.  [default: all]")
@seed_option
@json_option
@click.pass_context
def compare(ctx: click.Context, pairs: int | None, seed: int, as_json: bool) -> None:
    """Change the machine beside a job, and compare.

    Each field alone, all pairs of them, keys that nobody knows, boards that are set otherwise.

    Exit status 0 only if rows, colours, marks, text and exit status are those of a model that knows
    nothing of the product, and the job's play was sent though the machine has another.
    """
    from pixstep_dev.jobs import compare as campaign  # takes a while to load

    with progress.shown("comparisons") as show:
        outcome = campaign.run(campaign.JobComparePlan(pairs, seed), show)
    rows = [
        f"{outcome.alone} changes alone, {outcome.pairs} pairs, {outcome.boards} boards; "
        f"{outcome.refused} pairs are no machine",
        f"  {outcome.rows} rows judged; {outcome.edges} edges of a line made with 250 steps of "
        "play where the machine says 100",
    ]
    finish(ctx, asdict(outcome), rows, "all is as the model says", as_json=as_json)


@jobs_group.command()
@click.option("--times", type=click.IntRange(min=1), default=6, show_default=True, help="Trials.")
@click.option("--lines", type=click.IntRange(min=5), default=6, show_default=True)
@seed_option
@json_option
@click.pass_context
def disagree(ctx: click.Context, times: int, lines: int, seed: int, as_json: bool) -> None:
    """Let the boards of a job disagree, and resume.

    Exit status 0 only if nothing moved before it was decided, a row a board said what differs, and
    the rest was printed then, each line from its place.
    """
    from pixstep_dev.jobs import disagree as campaign  # takes a while to load

    with progress.shown(f"{times} disagreements") as show:
        outcome = campaign.run(campaign.DisagreePlan(times, lines, seed), show)
    kinds = ", ".join(f"{count} {name}" for name, count in outcome.kinds.items())
    rows = [
        f"{outcome.times} times boards disagreed ({kinds}); {outcome.together} went on together, "
        f"{outcome.homed} after homing",
        f"  {outcome.chains} chains of lines began at most {outcome.worst_start_steps} steps off",
    ]
    finish(ctx, asdict(outcome), rows, "nothing moved before it was decided", as_json=as_json)


COMMANDS = (jobs_group,)

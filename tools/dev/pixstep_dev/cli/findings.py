# SPDX-License-Identifier: MIT
"""What commands of campaigns have in common: their seed, and how they say what was found."""

from __future__ import annotations

import json
from typing import Any

import click

seed_option = click.option("--seed", type=click.IntRange(min=0), default=1, show_default=True)
json_option = click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")


def finish(
    ctx: click.Context, facts: dict[str, Any], rows: list[str], otherwise: str, *, as_json: bool
) -> None:
    """Print what a campaign found, as JSON or as text; end with 1 if there are complaints."""
    complaints = facts["complaints"]
    if as_json:
        click.echo(json.dumps(facts, indent=2))
    else:
        told = [f"FAIL: {text}" for text in complaints] or [f"  {otherwise}"]
        click.echo("\n".join([*rows, *told]))
    ctx.exit(1 if complaints else 0)

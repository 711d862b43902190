# SPDX-License-Identifier: MIT
"""Print jobs: many lines of several motors in one file, with the configuration they were made by.

`archive` is the container and `header` its job.toml, `shapes` and `tables` are the lines, `job` is
all of it. `making` makes one: `image` lays lines out, `ramps` are their accelerations, `sources`
read other descriptions, `assembly` puts it together. `comparison` compares a job's configuration
with today's by the `rules` of each field, `on_boards` with what the boards hold.
"""

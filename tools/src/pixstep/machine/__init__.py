# SPDX-License-Identifier: MIT
"""A machine file, machine.toml: pixel clock, boards, motors; read, checked, found, begun.

`model` is what a file holds, `reading` checks one and names line and key, `finding` says which
file is in force, `template` begins a new one, `describe` shows one.
"""

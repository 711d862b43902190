# SPDX-License-Identifier: MIT
"""What proves pixstep: measurements, faults injected, fuzzing, campaigns, generated documents.

pixstep itself never imports this package; `pixstep bench` finds it by name where it is installed.
"""

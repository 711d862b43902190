# SPDX-License-Identifier: MIT
"""What the page of `pixstep watch --web` shows: boards as they are looked at, a run of a job."""

# SPDX-License-Identifier: MIT
# PIXSTEP_PYTHON: the clone's own Python, with the packages that tools/setup installs, or any other.
find_program(PIXSTEP_PYTHON NAMES python3 HINTS "${CMAKE_SOURCE_DIR}/build/venv/bin" REQUIRED)
set(Python_EXECUTABLE "${PIXSTEP_PYTHON}")

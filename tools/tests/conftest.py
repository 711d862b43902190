# SPDX-License-Identifier: MIT
"""The tests of pixstep: their options and fixtures are the common ones."""

pytest_plugins = ["pytester", "common_fixtures", "serverbench"]

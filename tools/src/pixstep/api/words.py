# SPDX-License-Identifier: MIT
"""The words that arguments of the interface choose from, for editors and type checkers."""

from typing import Literal

Decode = Literal["smooth", "plain"]
Sync = Literal["free", "start", "lock"]
BoardKind = Literal["uno", "mega", "m1284"]
Parity = Literal["E", "O", "N"]
Direction = Literal["plus", "minus"]
Until = Literal["closed", "open"]
Switches = Literal["none", "home", "limits", "both"]
SharedLimit = Literal["none", "minus", "plus"]
Quantity = Literal["position", "speed", "steps"]
Separator = Literal["comma", "semicolon", "tab", "bar", "blank", "none"]
Decimals = Literal["point", "comma"]
Mode = Literal["lookahead", "mode1"]
FileKind = Literal["prn", "csv", "csb"]

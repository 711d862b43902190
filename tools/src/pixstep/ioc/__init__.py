# SPDX-License-Identifier: MIT
"""Motor records of EPICS over Channel Access: a server whose records drive the motors of a machine.

`settings`: what a machine file says as fields of a record; `saved`: what a record keeps over a
restart; `common`: fields that every record has; `names`: those of all PVs. With caproto: `motors`:
a record, what drives it and who waits for it; `channels`: its fields as PVs; `circuits`: monitors
in their order; `status`: PVs of the server; `server`: all of them together.
"""

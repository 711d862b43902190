# SPDX-License-Identifier: MIT
"""What turns the commands of motor records into motions of boards, and boards into statuses.

`BusDrives` owns a bus and has an `AxisDrive`, a `motor_record.traffic.Drive`, for each motor.
`starting.motors_of` are the motors of a machine file.
"""

from pixstep.motor_drive.axis import AxisDrive
from pixstep.motor_drive.bus import BusDrives, Pacer
from pixstep.motor_drive.starting import DrivenMotor

__all__ = ["AxisDrive", "BusDrives", "DrivenMotor", "Pacer"]

"""Measures of what a simulation did, one a file: functions of the kernel's output that know no gait."""

"""Columns of well-known loggers, by the pages that document them."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from gmfbo.errors import InputError, did_you_mean
from gmfbo.recordings.columns.column_mapping import MappedColumn
from gmfbo.recordings.columns.columns import RecordedColumns, last_part

_SERVO_THREAD_S = 1e-3  # LinuxCNC's usual servo period


@dataclass(frozen=True)
class Preset:
    """Columns of one logger.

    Attributes
    ----------
    page : str
        Page that documents the columns.
    columns : mapping of str to tuple
        By the usual name of a signal: columns that may hold it, the first that is there counts.
        A column stands for one that ends so, `axis0.pos_estimate` for `pos_estimate`.
    left_out : str
        What the preset does not map, and why.
    """

    page: str
    columns: Mapping[str, tuple[MappedColumn, ...]]
    left_out: str = ""


PRESETS: Mapping[str, Preset] = {
    "halsampler": Preset(
        page="https://linuxcnc.org/docs/html/man/man1/halsampler.1.html",
        columns={},
        left_out=(
            "the pins stand in the order of the sampler's configuration, so say which is which "
            "with --set position='column 2'; a row is taken to come each 1 ms, the usual servo "
            "period, unless --sample-time says otherwise"
        ),
    ),
    "odrive": Preset(
        page=("https://docs.odriverobotics.com/v/0.5.5/fibre_types/com_odriverobotics_ODrive.html"),
        columns={
            "reference": (MappedColumn("pos_setpoint", "rev"), MappedColumn("input_pos", "rev")),
            "position": (MappedColumn("pos_estimate", "rev"),),
            "velocity": (MappedColumn("vel_estimate", "rev/s"),),
            "current": (MappedColumn("Iq_measured", "A"),),
            "torque_command": (
                MappedColumn("torque_setpoint", "N.m"),
                MappedColumn("input_torque", "N.m"),
            ),
            "voltage": (MappedColumn("vbus_voltage", "V"),),
        },
        left_out="turns hold from firmware 0.5.1 on, before they were counts",
    ),
    "twincat_scope": Preset(
        page="https://infosys.beckhoff.com/content/1033/tcplclib_tc2_mc2/70133899.html",
        columns={
            "reference": (MappedColumn("SetPos"),),
            "position": (MappedColumn("ActPos"),),
            "velocity": (MappedColumn("ActVelo"),),
        },
        left_out=(
            "units are those of the NC axis, as the export states them; ActTorque is in a unit of "
            "the drive, so map it with its scale"
        ),
    ),
    "vesc": Preset(
        page="https://github.com/vedderb/vesc_tool/blob/master/vescinterface.cpp",
        columns={
            "time": (MappedColumn("ms_today", "ms"),),
            "position": (MappedColumn("encoder_position", "deg"),),
            "current": (MappedColumn("q_axis_current", "A"), MappedColumn("current_motor", "A")),
            "voltage": (MappedColumn("input_voltage", "V"),),
            "temperature": (MappedColumn("temp_motor", "degC"),),
        },
        left_out=(
            "erpm is the electrical speed: map velocity with the scale 1 / pole pairs and rpm"
        ),
    ),
}
"""By the name of `--preset`."""


def find_preset(name: str) -> Preset:
    """Preset of a logger.

    Raises
    ------
    InputError
        There is none of this name.
    """
    if name not in PRESETS:
        raise InputError(f"--preset: no preset '{name}'" + did_you_mean(name, PRESETS))
    return PRESETS[name]


def preset_columns(
    name: str, file: RecordedColumns, signals: Collection[str]
) -> dict[str, MappedColumn]:
    """Mapping of a recording by a preset.

    Parameters
    ----------
    name : str
        Of the preset.
    file : RecordedColumns
        As read.
    signals : collection of str
        Of the twin; others are left out.

    Returns
    -------
    dict of str to MappedColumn
        By signal, and `time`. A column that the file lacks, or that stands there for two axes, is
        left out; so is a unit where the file states one.

    Raises
    ------
    InputError
        There is no such preset, or the file has none of its columns.
    """
    preset = find_preset(name)
    known = {entry.column for entries in preset.columns.values() for entry in entries}
    if known and known.isdisjoint(last_part(column.name) for column in file.columns):
        raise InputError(
            f"--preset {name}: {file.label} has none of its columns ({', '.join(sorted(known))}); "
            "leave the preset out, and say which column is which by --set"
        )
    found: dict[str, MappedColumn] = {}
    for signal, candidates in preset.columns.items():
        for candidate in candidates if signal in (*signals, "time") else ():
            ends = [c for c in file.columns if last_part(c.name) == candidate.column]
            if len(ends) == 1:
                unit = "" if ends[0].unit else candidate.unit
                found[signal] = MappedColumn(ends[0].name, unit)
                break
    if name == "halsampler" and file.columns:
        found["time"] = _tagged_clock(file)
    return found


def _tagged_clock(file: RecordedColumns) -> MappedColumn:
    """The sample number that `halsampler -t` writes first, or else the count of rows."""
    first = file.columns[0]
    whole = bool(np.all(np.diff(first.values) >= 1.0)) and bool(np.all(first.values % 1.0 == 0.0))
    if first.values.size > 1 and whole:
        return MappedColumn(first.name, "s", _SERVO_THREAD_S)
    return MappedColumn("", sample_time=_SERVO_THREAD_S)

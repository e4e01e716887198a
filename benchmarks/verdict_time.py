"""What `sync` and `diagnose` take for recordings of a minute, verdict by verdict: processor time on one core, and peak memory.

A diagnosis costs the more, the more causes it tries. The arms are those of the study's generator: as described, with a load, with
several effects at once, and with one that no catalogue holds. Commands are run as in `growth`, and load their libraries.
"""

import json
import tempfile
from collections.abc import Sequence
from pathlib import Path

from benchmarks.growth import spent
from benchmarks.table import Table
from samples.generator.hidden.experiment import hide

LENGTH_S = 60.0
CASES: tuple[tuple[str, ...], ...] = (
    (),
    ("tip_payload",),
    ("cable_hardening", "stribeck_friction", "tip_payload", "actuator_gain"),
    ("cogging",),
)
"""effects that are hidden together"""
_FIRST_SEED = 7900


def measure(cases: Sequence[Sequence[str]] = CASES, length: float = LENGTH_S) -> Table:
    """Two recordings of each case: seconds for the sync of one, for the diagnosis with the other held out, and MB of that."""
    rows = []
    for seed, kinds in enumerate(cases, _FIRST_SEED):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            hide(list(kinds), seed, folder, seconds=(length, length))
            data = [folder / f"{part}.mcap" for part in ("fitted", "held_out")]
            synced = [
                spent("sync", length, here / "angles.csv", here / "log.csv", "--neck", here / "neck.yaml", *end)
                for here, end in ((d.with_suffix(""), ("--out", d, "--quiet")) for d in data)
            ]
            record = folder / "out/diagnosis.json"
            words = (data[0], "--held-out", data[1], "--out", record.parent, "--quiet")
            diagnosed = spent("diagnose", 2 * length, *words)
            found = json.loads(record.read_text())
        label = f"{', '.join(kinds) or 'nothing hidden'}: {found['verdict']}, {len(found['causes'])} named"
        rows.append((label, (synced[0].seconds, diagnosed.seconds, diagnosed.megabytes)))
    title = f"Time of a verdict, two recordings of {length:g} s each"
    return Table(title, ("sync s", "diagnose s", "diagnose peak MB"), tuple(rows))

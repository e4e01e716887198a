"""The motion watched while it is recorded: by the newest seconds of the video alone, and by video and log together."""

from collections.abc import Sequence

import numpy as np

from calibration.camera import Camera
from mechanism.arm import arm_of
from mechanism.description import Neck
from synchronisation.angles import Angles
from synchronisation.clocks.frame_geometry import cable_winding
from synchronisation.encoder_log import motor_log
from vision.extract import ExtractionOptions
from xneck.recording.recording_folder import Recording
from xneck.watch.finding import Finding
from xneck.watch.frame_findings import repetition_findings
from xneck.watch.log_findings import refused_finding
from xneck.watch.log_watch import LogWatch
from xneck.watch.motion_findings import (
    Shift,
    Window,
    motion_findings,
    repetition_finding,
    small_motion_finding,
    untraced_loss,
)
from xneck.watch.video_watch import VideoWatch
from xneck.watch.window_angles import window_angles
from xneck_foundation.errors import Refused
from xneck_foundation.recovery import collected_recoveries

WINDOW_S, MIN_WINDOW_S = 8.0, 6.0
"""s of the newest motion that are judged, and that there must be (docs/thresholds.md)"""
MIN_WINDOW_FRAMES = 30
"""frames of the window with all angles that are judged at least (docs/thresholds.md)"""
CHECK_S = 1.5
"""s of video between judgements of the motion (docs/thresholds.md)"""
WINDOW_HZ = 15.0
"""frames a second of the window that are used: the speeds compared are filtered at 6 Hz"""
LOG_REACH_S = 14.0
"""s of log before the window in which its motion is looked for: clocks differ by seconds, and writers keep some back
(docs/thresholds.md)"""
_MAX_SHIFTS = 20
"""windows' shifts that are kept"""


class MotionWatch:
    """What the newest seconds of the motion say, from time to time."""

    def __init__(self, recording: Recording, neck: Neck, camera: Camera, options: ExtractionOptions) -> None:
        self._recording, self._neck, self._camera, self._options = recording, neck, camera, options
        self._arm = arm_of(neck)
        self._shifts: list[Shift] = []
        self._suspects: set[str] = set()
        """kinds that the last look at log and video would name: they are named if the next look says the same"""
        self._last_check_s = -np.inf
        self._largest_winding_m = 0.0

    def is_due(self, now_s: float, first_s: float) -> bool:
        """Whether it is time for another look, at a frame's time and with the first frame's, s."""
        return now_s - first_s >= MIN_WINDOW_S and now_s - self._last_check_s >= CHECK_S

    def look(self, now_s: float, seen: VideoWatch, log: LogWatch, logged_until_s: float) -> list[Finding]:
        """At the window that ends with the frame at `now_s`; what is later than `logged_until_s` may not be in the log yet."""
        self._last_check_s = now_s
        frames = [f for f in seen.recent if f.time > now_s - WINDOW_S]
        findings = list(repetition_findings(frames))
        try:
            angles = window_angles(
                self._neck, self._camera, self._options, frames, str(self._recording.video), WINDOW_HZ
            )
        except Refused:  # markers are out of sight, which is said by itself
            return findings
        if len(angles.time) < MIN_WINDOW_FRAMES:
            return findings
        winding = np.ptp(cable_winding(self._arm, angles.alpha), axis=0)
        self._largest_winding_m = max(self._largest_winding_m, float(winding.max()))
        small = small_motion_finding(self._arm, angles, seen.first_s or 0.0, self._largest_winding_m)
        repeated = repetition_finding(self._arm, angles)
        findings += [f for f in (small, repeated) if f is not None]
        logged = angles.time <= logged_until_s
        if log.can_be_compared and np.sum(logged) >= MIN_WINDOW_FRAMES:
            compared = Angles(angles.time[logged], angles.alpha[logged], angles.sigma[logged])
            findings += self._compared_with_log(compared, log, seen.times)
        return findings

    def _compared_with_log(self, angles: Angles, log: LogWatch, frame_times: Sequence[float]) -> list[Finding]:
        """What log and video say of one motion; of signs, units and labels what two looks in turn agree on."""
        rows = log.since(log.newest_s - WINDOW_S - LOG_REACH_S)
        if rows is None or rows.time[-1] - rows.time[0] < MIN_WINDOW_S:
            return []
        begin_s = float(rows.time[0])
        try:
            with collected_recoveries() as recovered:
                motors = motor_log(rows, self._neck, self._recording.log)
                found, shift = motion_findings(self._neck, self._arm, Window(angles, motors))
        except Refused as refusal:
            return [refused_finding("log", refusal, begin_s)]
        findings = [Finding("log", begin_s, "log", line, where=line) for line in recovered]
        findings += [finding for finding in found if finding.kind in self._suspects]
        self._suspects = {finding.kind for finding in found}
        if shift is not None:
            self._shifts = [*self._shifts[-_MAX_SHIFTS:], shift]
            period = float(np.median(np.diff(frame_times)))
            if (loss := untraced_loss(self._shifts, WINDOW_S, period)) is not None:
                findings.append(loss)
                self._shifts = []
        return findings

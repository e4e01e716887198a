"""A recording folder watched while the experiment runs: findings as they show, and at the end what the recording will give.

One thread does all: frames are followed as they come, and while none is there the log is read. Whether the files still grow says
whether the recording goes on.
"""

import contextlib
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from calibration.camera import Camera
from mechanism.arm import arm_of
from mechanism.description import markers_of, read_neck
from synchronisation.angles import Angles
from synchronisation.clocks.frame_geometry import cable_winding
from synchronisation.encoder_log import motor_log
from vision.extract import ExtractionOptions
from vision.video import describe_video
from xneck.recording.camera_stages import camera_of, extraction_options
from xneck.recording.recording_folder import Recording
from xneck.recording.watched_tracks import write_watched_tracks
from xneck.watch.finding import Finding, Findings
from xneck.watch.frame_findings import frame_findings, repetition_findings
from xneck.watch.growing_file import GrowingFile
from xneck.watch.growing_log import GrowingLog
from xneck.watch.growing_video import GrowingVideo
from xneck.watch.light_findings import light_findings
from xneck.watch.log_findings import MIN_ROWS, gap_findings, refused_finding, stopped_finding, time_finding
from xneck.watch.marker_findings import marker_findings
from xneck.watch.motion_findings import (
    Shift,
    Window,
    motion_findings,
    repetition_finding,
    small_motion_finding,
    untraced_loss,
)
from xneck.watch.outcome import Outcome, outcome_of
from xneck.watch.video_watch import VideoWatch
from xneck.watch.window_angles import window_angles
from xneck_foundation.errors import Refused
from xneck_foundation.one_blas_thread import one_blas_thread
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
GROWING_S = 10.0
"""s without growth after which a video is no longer being written"""
POLL_S = 0.2
"""s between looks at files that did not grow"""
LIKELY_ENDED_S = 1.5
"""s without growth after which the outcome is said (docs/thresholds.md)"""
PAUSE_RATIO, MAX_PAUSE_S = 1.5, 20.0
"""... and for so many times the longest pause before, and the longest that counts, s (docs/thresholds.md)"""
SAME_FRAMES = 10
"""frames that a decoder may have kept back until the end, and that change no outcome"""
GAP_ROWS_S = 12.0
"""s of log that are looked through for gaps"""

Say = Callable[[dict[str, Any]], object]
"""told of every event, ready for JSON"""


@dataclass(frozen=True)
class WallClock:
    """The time that passes while files grow; a test has its own."""

    now: Callable[[], float] = time.monotonic
    sleep: Callable[[float], None] = time.sleep


@dataclass(frozen=True)
class WatchResult:
    """What was found, and what the recording will give."""

    findings: tuple[Finding, ...]
    outcome: Outcome
    frames: int
    skipped: int
    rows: int
    tracked_frames: int
    """frames that `run` need not read again"""


@one_blas_thread
def watch(
    recording: Recording,
    say: Say,
    ended_after_s: float = 5.0,
    tracks_file: Path | None = None,
    clock: WallClock = WallClock(),
) -> WatchResult:
    """Watches a recording until neither of its files has grown for `ended_after_s`, or until an interrupt (Ctrl-C).

    say: is called with each event as it comes: findings, that frames are skipped, and the outcome.
    tracks_file: where the tracks are kept that `run` can go on from.
    Raises Refused where neck.yaml or the camera cannot be used.
    """
    return _Watch(recording, say, ended_after_s, clock).run(tracks_file)


class _Watch:
    def __init__(self, recording: Recording, say: Say, ended_after_s: float, clock: WallClock) -> None:
        assert recording.video is not None
        self._recording, self._say, self._ended_after_s, self._clock = recording, say, ended_after_s, clock
        self._neck = read_neck(recording.neck)
        self._markers = markers_of(self._neck, str(recording.neck))
        self._arm = arm_of(self._neck)
        self._options: ExtractionOptions = extraction_options(recording)
        self._camera: Camera = camera_of(recording)[0]
        self._video_file = GrowingFile(recording.video, self._wait)
        self._video = GrowingVideo(recording.video, self._video_file)
        self._log = GrowingLog(GrowingFile(recording.log), self._neck)
        self._seen = VideoWatch(self._markers, self._options)
        self._findings = Findings()
        self._lost_since: dict[int, float] = {}
        self._shifts: list[Shift] = []
        self._suspects: set[str] = set()
        """kinds that the last look at log and video would name: they are named if the next look says the same"""
        self._stopped = False
        self._log_ok, self._log_time_ok = True, False
        self._gap_after = -np.inf
        self._last_check_s = -np.inf
        self._largest_winding_m = 0.0
        self._last_video_size = self._video_file.size
        self._video_grown_at = -np.inf
        self._grown_at = self._log_grown_at = self._polled_at = clock.now()
        self._longest_pause_s = 0.0
        self._log_longest_s: float | None = None
        self._video_s_at_log = -np.inf
        """time of the newest frame when the log grew last, s: what is later may not be in the log yet"""
        self._outcome: tuple[tuple[int, int], Outcome] | None = None
        """the outcome, and of how many frames and rows"""

    def run(self, tracks_file: Path | None) -> WatchResult:
        """Until the recording ends."""
        with contextlib.suppress(KeyboardInterrupt):
            self._follow()
        outcome = self._say_outcome()
        tracked = self._keep_tracks(tracks_file) if tracks_file is not None else 0
        result = WatchResult(
            findings=tuple(self._findings.all),
            outcome=outcome,
            frames=self._seen.frames,
            skipped=self._seen.skipped,
            rows=self._log.rows,
            tracked_frames=tracked,
        )
        self._say(
            {
                "event": "end",
                "findings": len(result.findings),
                "frames": result.frames,
                "frames_skipped": result.skipped,
                "rows": result.rows,
                "frames_kept_for_run": tracked,
            }
        )
        return result

    def _follow(self) -> None:
        """Frames as they come; the log alone where the video cannot be read before it is finished."""
        while (unreadable := self._video.wait_for_end) is None:
            if not self._wait():
                return
        if unreadable:
            what = "has its index at its end, so that it cannot be read before it is finished: the log alone is watched"
            self._name([Finding("video", 0.0, "camera", what, "record into mkv or fragmented mp4 to have it watched")])
            while self._wait():
                pass
            return
        try:
            self._follow_frames()
        except Refused as refusal:
            self._name([refused_finding("video", refusal, self._newest_s)])
            while self._wait():
                pass

    def _follow_frames(self) -> None:
        for growing in self._video.frames():
            if self._seen.first_s is None:
                self._refuse_other_size()
            was_catching_up = self._seen.catching_up
            # what no longer grows can be read in peace
            grows = self._clock.now() - self._video_grown_at < GROWING_S
            behind = self._video.seconds_behind(growing.frame.time) if grows else 0.0
            seen = self._seen.take(growing, behind)
            if self._seen.catching_up != was_catching_up:
                self._say(
                    {"event": "behind", "time_s": growing.frame.time, "behind_s": behind, "skips": not was_catching_up}
                )
            self._name(frame_findings(self._seen.times))
            if seen is not None:
                self._look(growing.frame.time)
            if self._clock.now() - self._polled_at >= POLL_S:
                self._poll()
            if self._stopped:
                return

    def _refuse_other_size(self) -> None:
        assert self._video.size is not None
        if self._video.size != self._camera.size:
            sizes = ["x".join(map(str, size)) for size in (self._video.size, self._camera.size)]
            raise Refused(
                self._recording.video or "video",
                f"is {sizes[0]}, the camera was calibrated at {sizes[1]}",
                "calibrate with pictures of the video's size",
            )

    @property
    def _newest_s(self) -> float:
        return self._seen.times[-1] if self._seen.times else 0.0

    def _look(self, now_s: float) -> None:
        """At the newest frame, and from time to time at the motion."""
        frames = list(self._seen.recent)
        ids = [marker.id for marker in self._markers.on_bars]
        self._name(marker_findings(frames, ids, self._lost_since))
        self._name(light_findings(frames[-200:]))
        assert self._seen.first_s is not None
        if now_s - self._seen.first_s >= MIN_WINDOW_S and now_s - self._last_check_s >= CHECK_S:
            self._last_check_s = now_s
            self._check_motion(now_s)

    def _check_motion(self, now_s: float) -> None:
        """All that the newest seconds of the motion say."""
        frames = [f for f in self._seen.recent if f.time > now_s - WINDOW_S]
        self._name(repetition_findings(frames))
        try:
            angles = window_angles(
                self._neck, self._camera, self._options, frames, str(self._recording.video), WINDOW_HZ
            )
        except Refused:  # markers are out of sight, which is said by itself
            return
        if len(angles.time) < MIN_WINDOW_FRAMES:
            return
        winding = np.ptp(cable_winding(self._arm, angles.alpha), axis=0)
        self._largest_winding_m = max(self._largest_winding_m, float(winding.max()))
        first_s = self._seen.first_s or 0.0
        small = small_motion_finding(self._arm, angles, first_s, self._largest_winding_m)
        repeated = repetition_finding(self._arm, angles)
        self._name([f for f in (small, repeated) if f is not None])
        # what the log has not told yet cannot be compared
        logged = angles.time <= self._video_s_at_log
        if not self._log_ok or not self._log_time_ok or np.sum(logged) < MIN_WINDOW_FRAMES:
            return
        self._compare_with_log(Angles(angles.time[logged], angles.alpha[logged], angles.sigma[logged]))

    def _compare_with_log(self, angles: Angles) -> None:
        """What log and video say of one motion; of signs, units and labels what two looks in turn agree on."""
        rows = self._log.since(self._log.newest_s - WINDOW_S - LOG_REACH_S)
        if rows is None or rows.time[-1] - rows.time[0] < MIN_WINDOW_S:
            return
        try:
            with collected_recoveries() as recovered:
                log = motor_log(rows, self._neck, self._recording.log)
                found, shift = motion_findings(self._neck, self._arm, Window(angles, log))
        except Refused as refusal:
            self._name([refused_finding("log", refusal, float(rows.time[0]))])
            return
        self._name([Finding("log", float(rows.time[0]), "log", line, where=line) for line in recovered])
        confirmed = [finding for finding in found if finding.kind in self._suspects]
        self._suspects = {finding.kind for finding in found}
        self._name(confirmed)
        if shift is not None:
            self._shifts = [*self._shifts[-20:], shift]
            period = float(np.median(np.diff(self._seen.times)))
            if (loss := untraced_loss(self._shifts, WINDOW_S, period)) is not None:
                self._name([loss])
                self._shifts = []

    def _poll(self) -> bool:
        """Reads what is new of the log; whether anything grew."""
        now = self._clock.now()
        self._polled_at = now
        size = self._video_file.size
        video_grew, self._last_video_size = size != self._last_video_size, size
        self._video_grown_at = now if video_grew else self._video_grown_at
        log_grew = False
        if self._log_ok:
            try:
                log_grew = self._log.poll()
            except Refused as refusal:
                self._log_ok = False
                self._name([refused_finding("log", refusal, self._log.newest_s if self._log.rows else 0.0)])
        if log_grew:
            if self._log_longest_s is not None or now > self._log_grown_at:
                self._log_longest_s = max(self._log_longest_s or 0.0, now - self._log_grown_at)
            self._log_grown_at, self._video_s_at_log = now, self._newest_s
            self._check_log()
        elif self._log_ok and video_grew:
            in_chunks = self._recording.log.suffix == ".mcap"
            silent = now - self._log_grown_at
            if (stop := stopped_finding(silent, self._log_longest_s, self._log.newest_s, in_chunks)) is not None:
                self._name([stop])
        if video_grew or log_grew:
            if self._seen.frames or self._log.rows:
                self._longest_pause_s = min(max(self._longest_pause_s, now - self._grown_at), MAX_PAUSE_S)
            self._grown_at = now
        return video_grew or log_grew

    def _check_log(self) -> None:
        where = str(self._recording.log)
        if not self._log_time_ok:
            rows = self._log.since(-np.inf)
            if rows is None or len(rows) < MIN_ROWS:
                return
            if (finding := time_finding(rows, where)) is not None:
                self._log_ok = False
                self._name([finding])
                return
            self._log_time_ok = True
        rows = self._log.since(self._log.newest_s - GAP_ROWS_S)
        if rows is not None:
            gaps = gap_findings(rows, self._gap_after)
            self._name(gaps)
            self._gap_after = max([self._gap_after, *(gap.onset_s for gap in gaps)])

    def _wait(self) -> bool:
        """Reads the log, and waits a little for more; False where the recording has ended or was interrupted."""
        try:
            if self._poll():
                return True
            idle = self._clock.now() - self._grown_at
            # writers that collect seconds pause for as long
            pause_s = PAUSE_RATIO * self._longest_pause_s
            if self._seen.frames or self._log.rows:
                if idle >= max(self._ended_after_s, pause_s):
                    return False
                if idle >= max(min(LIKELY_ENDED_S, self._ended_after_s), pause_s):
                    self._say_outcome()  # at once, as it has most likely ended
            self._clock.sleep(POLL_S)
            return True
        except KeyboardInterrupt:
            self._stopped = True
            return False

    def _say_outcome(self) -> Outcome:
        """The outcome of all that was read, said once, and again where more was read since."""
        state = (self._seen.frames, self._log.rows)
        if self._outcome is not None:
            (frames_before, rows_before), outcome = self._outcome
            if rows_before == state[1] and state[0] - frames_before < SAME_FRAMES:
                return outcome
        rows = self._log.since(self._log.newest_s - 45.0) if self._log_ok else None
        frames = list(self._seen.recent)
        outcome = outcome_of(self._recording, self._neck, self._camera, self._options, frames, rows)
        self._outcome = state, outcome
        self._say({"event": "outcome", **outcome.as_json()})
        return outcome

    def _keep_tracks(self, file: Path) -> int:
        """Writes what `run` can go on from; the number of frames in it."""
        assert self._recording.video is not None
        if not self._seen.frames or not self._video.is_still_the_same():
            return 0
        try:
            kept = self._seen.kept_tracks(describe_video(self._recording.video))
        except Refused:  # what `run` will say of it
            return 0
        if kept:
            write_watched_tracks(file, self._recording.video, self._neck, self._options, kept)
        return sum(len(tracks.time) for tracks in kept.values())

    def _name(self, findings: Iterable[Finding]) -> None:
        for finding in self._findings.new(findings):
            said = self._newest_s if finding.clock == "camera" else self._log.newest_s
            self._say(finding.as_json(said))

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
from mechanism.description import read_neck
from vision.extract import ExtractionOptions
from vision.markers.known_markers import known_markers
from vision.video import describe_video
from xneck.recording.camera_stages import camera_of, extraction_options
from xneck.recording.recording_folder import Recording
from xneck.recording.watched_tracks import write_watched_tracks
from xneck.watch.finding import Finding, Findings
from xneck.watch.frame_findings import frame_findings
from xneck.watch.growing_file import GrowingFile
from xneck.watch.growing_video import GrowingVideo
from xneck.watch.growth import Growth
from xneck.watch.light_findings import light_findings
from xneck.watch.log_findings import refused_finding
from xneck.watch.log_watch import LogWatch
from xneck.watch.marker_findings import marker_findings
from xneck.watch.motion_watch import MotionWatch
from xneck.watch.outcome import Outcome, outcome_of
from xneck.watch.video_watch import VideoWatch
from xneck_foundation.errors import Refused
from xneck_foundation.one_blas_thread import one_blas_thread

POLL_S = 0.2
"""s between looks at files that did not grow"""
SAME_FRAMES = 10
"""frames that a decoder may have kept back until the end, and that change no outcome"""
_OUTCOME_ROWS_S = 45.0
"""s of the newest log by which the outcome is told"""
_LIGHT_FRAMES = 200
"""newest frames whose light is judged"""

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
        self._markers = known_markers(self._neck, recording.neck)
        self._options: ExtractionOptions = extraction_options(recording)
        self._camera: Camera = camera_of(recording)[0]
        self._video_file = GrowingFile(recording.video, self._wait)
        self._video = GrowingVideo(recording.video, self._video_file)
        self._log = LogWatch(GrowingFile(recording.log), self._neck)
        self._seen = VideoWatch(self._markers, self._options)
        self._motion = MotionWatch(recording, self._neck, self._camera, self._options)
        self._findings = Findings()
        self._lost_since: dict[int, float] = {}
        self._stopped = False
        self._polled_at = clock.now()
        self._growth = Growth(self._polled_at, self._video_file.size)
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
            grows = self._growth.video_grows(self._clock.now())
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
        self._name(light_findings(frames[-_LIGHT_FRAMES:]))
        assert self._seen.first_s is not None
        if self._motion.is_due(now_s, self._seen.first_s):
            self._name(self._motion.look(now_s, self._seen, self._log, self._video_s_at_log))

    def _poll(self) -> bool:
        """Reads what is new of the log; whether anything grew."""
        now = self._polled_at = self._clock.now()
        video_grew = self._growth.video_grew(now, self._video_file.size)
        log_grew, findings = self._log.poll()
        if log_grew:
            self._growth.log_grew(now)
            self._video_s_at_log = self._newest_s
        elif video_grew:
            findings += self._log.silence_findings(self._growth.log_silent_s(now), self._growth.log_longest_s)
        self._name(findings)
        if video_grew or log_grew:
            self._growth.grew(now, self._has_begun)
        return video_grew or log_grew

    @property
    def _has_begun(self) -> bool:
        return bool(self._seen.frames or self._log.rows)

    def _wait(self) -> bool:
        """Reads the log, and waits a little for more; False where the recording has ended or was interrupted."""
        try:
            if self._poll():
                return True
            if self._has_begun:
                now = self._clock.now()
                if self._growth.has_ended(now, self._ended_after_s):
                    return False
                if self._growth.has_likely_ended(now, self._ended_after_s):
                    self._say_outcome()
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
        rows = self._log.since(self._log.newest_s - _OUTCOME_ROWS_S) if self._log.is_readable else None
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

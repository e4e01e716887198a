"""Whether a recording still grows: when its files grew last, and how long they paused before."""

PAUSE_RATIO, MAX_PAUSE_S = 1.5, 20.0
"""a recording has not ended before so many times its longest pause before, and the longest that counts, s (docs/thresholds.md)"""
LIKELY_ENDED_S = 1.5
"""s without growth after which the outcome is said (docs/thresholds.md)"""
GROWING_S = 10.0
"""s without growth after which a video is no longer being written"""


class Growth:
    """Told of each look at the files; times are of one clock, s."""

    def __init__(self, now: float, video_size: int) -> None:
        self._video_size = video_size
        self._video_grown_at = -float("inf")
        self._grown_at = self._log_grown_at = now
        self._longest_pause_s = 0.0
        self.log_longest_s: float | None = None
        """the longest time in which the log did not grow before; None where it never grew twice"""

    def video_grew(self, now: float, size: int) -> bool:
        """Whether the video has another size than at the look before."""
        grew, self._video_size = size != self._video_size, size
        if grew:
            self._video_grown_at = now
        return grew

    def log_grew(self, now: float) -> None:
        """The log has new rows."""
        if self.log_longest_s is not None or now > self._log_grown_at:
            self.log_longest_s = max(self.log_longest_s or 0.0, now - self._log_grown_at)
        self._log_grown_at = now

    def grew(self, now: float, begun: bool) -> None:
        """One of them grew; pauses count once the recording has begun."""
        if begun:
            self._longest_pause_s = min(max(self._longest_pause_s, now - self._grown_at), MAX_PAUSE_S)
        self._grown_at = now

    def log_silent_s(self, now: float) -> float:
        """Since the log grew."""
        return now - self._log_grown_at

    def video_grows(self, now: float) -> bool:
        """Whether the video is being written: what no longer grows can be read in peace."""
        return now - self._video_grown_at < GROWING_S

    def has_ended(self, now: float, after_s: float) -> bool:
        """Whether nothing has grown for so long, and for longer than writers that collect seconds pause."""
        return now - self._grown_at >= max(after_s, PAUSE_RATIO * self._longest_pause_s)

    def has_likely_ended(self, now: float, after_s: float) -> bool:
        """Whether it is time to say what the recording will give."""
        return self.has_ended(now, min(LIKELY_ENDED_S, after_s))

"""What goes wrong while a recording grows is named within ten seconds; of what is right nothing is said."""

import json
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np
import pytest

from mechanism.description import markers_of, read_neck
from tests.xneck.watch.experiment import OFFSET_S, SAMPLE, Array, Experiment, encoded
from vision.markers.video_tracking import MarkerTracks, track_video
from vision.shutter import Shutter
from vision.video import describe_video, read_frames
from xneck.batch.recording_task import run_recording_task
from xneck.recording.camera_stages import extraction_options
from xneck.recording.recording_folder import read_recording
from xneck.recording.watched_tracks import read_watched_tracks
from xneck.watch.watch import WallClock, WatchResult, watch

TRUTH = json.loads((SAMPLE.parent / "truth.json").read_text())["recording"]
Begin = Callable[..., Experiment]


def watched(experiment: Experiment, tracks: Path | None = None) -> WatchResult:
    recording = read_recording(experiment.video.parent, growing=True)
    return watch(recording, experiment.say, 2.0, tracks, experiment.clock)


def columns(stem: str, factor: float, since: float = -np.inf) -> Callable[[dict[str, Array]], dict[str, Array]]:
    """Columns multiplied from a time on, s of the camera's clock."""

    def change(table: dict[str, Array]) -> dict[str, Array]:
        late = table["time"] - OFFSET_S >= since
        return {k: np.where(late, v * factor, v) if k.startswith(stem) else v for k, v in table.items()}

    return change


@pytest.mark.parametrize(
    ("change", "kind", "words"),
    [
        (columns("theta2", -1), "signs_or_labels", "theta2 runs against the camera"),
        (columns("f", -1), "signs_or_units", "wrong sign"),
        (columns("theta", np.degrees(1)), "signs_or_units", "theta is in degrees"),
    ],
)
def test_a_log_that_means_something_else_is_named_within_ten_seconds_of_its_beginning(
    begin: Begin, change: Callable, kind: str, words: str
) -> None:
    experiment = begin(10.5, change)
    watched(experiment)
    (at, finding), *_ = experiment.named(kind)
    assert words in finding["what"]
    assert at < 10
    assert set(experiment.findings) == {kind}


def test_signs_that_turn_on_the_way_are_named_too(begin: Begin) -> None:
    """A motor's plug is turned at 6 s, which `sync` would call a cable that contradicts all others."""
    experiment = begin(16.5, columns("theta3", -1, since=6.0))
    watched(experiment)
    (at, finding), *_ = experiment.named("signs_or_labels")
    assert "3" in finding["what"]
    assert 6 < at < 16


def test_gaps_of_the_log_and_its_end_are_named_at_once(begin: Begin) -> None:
    def change(table: dict[str, Array]) -> dict[str, Array]:
        t = table["time"] - OFFSET_S
        kept = ((t < 2) | (t > 2.3)) & (t < 4)
        return {name: values[kept] for name, values in table.items()}

    experiment = begin(8.0, change)
    watched(experiment)
    ((at, gap),) = experiment.named("log_gap")
    assert gap["onset_s"] == pytest.approx(OFFSET_S + 2, abs=0.01)
    assert 2.3 <= at < 3
    ((at, stop),) = experiment.named("log_stopped")
    assert stop["onset_s"] == pytest.approx(OFFSET_S + 4, abs=0.01)
    assert 4 < at < 8
    assert set(experiment.findings) == {"log_gap", "log_stopped"}


def test_a_log_in_milliseconds_is_named_with_its_first_rows(begin: Begin) -> None:
    experiment = begin(3.0, lambda table: table | {"time": 1e3 * table["time"]})
    result = watched(experiment)
    ((at, finding),) = experiment.named("log")
    assert "milliseconds" in finding["what"]
    assert at < 1
    assert result.outcome.clock is None


def frames_15_hz(seconds: float) -> list[tuple[float, np.ndarray]]:
    frames = []
    for frame in read_frames(SAMPLE / "video.mp4"):
        if frame.time > seconds:
            break
        if frame.index % 2 == 0:
            frames.append((frame.time, np.array(frame.grey)))
    return frames


def test_what_happens_before_the_camera_is_named(begin: Begin, tmp_path: Path) -> None:
    """A hand covers the middle of the picture from 2 to 3 s, six frames are lost at 4 s, and a lamp dazzles from 6 s on."""
    changed = []
    for k, (time, grey) in enumerate(frames_15_hz(8.0)):
        if 60 <= k < 66:
            continue
        if 2 <= time < 3:
            grey[300:420, 500:780] = 120
        if time >= 6:
            grey = np.minimum(grey.astype(np.uint16) * 3 // 2, 255).astype(np.uint8)
        changed.append((time, grey))
    lost_at = frames_15_hz(4.5)[60][0]
    experiment = begin(8.0, packets=encoded(tmp_path / "e.mkv", changed))
    watched(experiment)
    lost = experiment.named("marker_lost")
    assert lost
    assert all(abs(finding["onset_s"] - 2) < 0.15 and at < 5 for at, finding in lost)
    ((at, gap),) = experiment.named("lost_frames")
    assert gap["onset_s"] == pytest.approx(lost_at, abs=0.1)
    assert at < lost_at + 3
    ((at, bright),) = experiment.named("overexposed")
    assert bright["onset_s"] == pytest.approx(6, abs=0.5)
    assert at < 8.5
    assert set(experiment.findings) == {"marker_lost", "lost_frames", "overexposed"}


def test_a_motion_that_repeats_itself_and_a_lamp_that_flickers_are_named(begin: Begin, tmp_path: Path) -> None:
    """From 3 s on the arm goes back and forth between two of its poses; the lamp flickers throughout."""
    frames = frames_15_hz(4.5)
    forth = [grey for time, grey in frames if 3 <= time < 3.8]
    loop = [*forth, *forth[-2:0:-1]]
    pictures = [grey for time, grey in frames if time < 3]
    pictures += [loop[k % len(loop)] for k in range(8 * 15)]
    dim = [(g * (1.0 if k % 2 else 0.88)).astype(np.uint8) for k, g in enumerate(pictures)]
    still = begin(
        11.0,
        lambda table: {k: v[:200] for k, v in table.items()},
        encoded(tmp_path / "e.mkv", ((k / 15, g) for k, g in enumerate(dim))),
    )
    watched(still)
    (at, finding), *_ = still.named("periodic_motion")
    assert f"every {len(loop) / 15:.2f} s"[:9] in finding["what"]
    assert 5 < at < 11
    assert still.named("flicker")[0][0] < 4


def test_frames_that_are_lost_without_a_trace_are_named(begin: Begin, tmp_path: Path) -> None:
    """Two frames of 15 Hz are missing at 10 s and the later stamps go on evenly."""
    shown = []
    for k, (time, grey) in enumerate(frames_15_hz(17.0)):
        if k not in (150, 151):
            shown.append((time - 2 / 15 if k > 151 else time, grey))
    experiment = begin(17.0, packets=encoded(tmp_path / "e.mkv", shown))
    watched(experiment)
    (at, finding), *_ = experiment.named("lost_frames_untraced")
    assert 10 < at < 17
    assert "frames were lost" in finding["what"]
    assert 2 < finding["onset_s"] < 10
    assert set(experiment.findings) == {"lost_frames_untraced"}


def test_a_plain_mp4_cannot_be_read_before_it_is_finished_and_the_log_is_watched(begin: Begin) -> None:
    def change(table: dict[str, Array]) -> dict[str, Array]:
        t = table["time"] - OFFSET_S
        return {name: values[(t < 3) | (t > 3.5)] for name, values in table.items()}

    experiment = begin(6.0, change, form="mp4", options={})
    result = watched(experiment)
    (at, said), (gap_at, _) = experiment.named("video")[0], experiment.named("log_gap")[0]
    assert "index at its end" in said["what"]
    assert at < 1
    assert gap_at < 4.5
    assert result.frames == 0
    assert result.outcome.clock is None


def test_a_fragmented_mp4_is_followed(begin: Begin) -> None:
    fragments = {"movflags": "frag_keyframe+empty_moov+default_base_moof", "frag_duration": "500000"}
    experiment = begin(3.0, form="mp4", options=fragments)
    assert watched(experiment).frames > 80
    assert experiment.findings == []


@dataclass(frozen=True)
class Watched:
    """The sample as it grew, what the watcher came to, and the folder of results in which it left its tracks."""

    experiment: Experiment
    result: WatchResult
    results: Path

    @property
    def tracks(self) -> Path:
        return self.results / "watched.npz"


@pytest.fixture(scope="module")
def sample_watched(begin_in: Begin, tmp_path_factory: pytest.TempPathFactory) -> Watched:
    folder = tmp_path_factory.mktemp("watched")
    experiment = begin_in(folder, 14.0, corners="template")
    results = folder / "a" / experiment.video.parent.name
    return Watched(experiment, watched(experiment, results / "watched.npz"), results)


def test_the_result_of_run_is_the_same_with_and_without_watch(sample_watched: Watched, tmp_path: Path) -> None:
    recording = read_recording(sample_watched.experiment.video.parent)
    with_watch, without = sample_watched.results, tmp_path / sample_watched.results.name
    for out in (with_watch, without):
        run_recording_task(recording, out)
    names = sorted(path.name for path in without.iterdir())
    assert "report.html" in names
    for name in names:
        one, other = ((out / name).read_bytes() for out in (with_watch, without))
        if name == "result.json":
            one, other = (json.dumps({**json.loads(x), "seconds": 0, "written_by": ""}).encode() for x in (one, other))
        assert one == other, name


def test_nothing_is_said_of_the_sample_and_run_goes_on_from_what_was_tracked(
    sample_watched: Watched, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The clock is the true one; the tracks are those of a finished video to the last bit, and no frame is read again for them."""
    experiment, result, tracks_file = sample_watched.experiment, sample_watched.result, sample_watched.tracks
    assert experiment.findings == []
    clock = result.outcome.clock
    assert clock is not None
    truth = TRUTH["offset_s"] + TRUTH["skew"] * (clock["camera_middle_s"] - TRUTH["middle_s"])
    assert abs(clock["offset_s"] - truth) < max(0.5e-3, 4 * clock["offset_sigma_s"])
    identified = {(p.name, p.index) for p, judged in result.outcome.parameters if judged.identified}
    assert {("k", j) for j in range(1, 5)} <= identified
    recording = read_recording(experiment.video.parent)
    neck, options = read_neck(recording.neck), extraction_options(recording)
    video = describe_video(experiment.video)
    assert result.tracked_frames == video.frames
    stored = read_watched_tracks(tracks_file, video, neck, options)
    assert set(stored) == set(video.segments)
    assert len(video.segments) == 2
    markers = markers_of(neck, "neck.yaml")
    anew = track_video(video, markers, options.tracking)
    monkeypatch.setattr("vision.markers.video_tracking.read_segment", None)
    taken = track_video(video, markers, options.tracking, tracked=stored)
    for field in fields(MarkerTracks):
        np.testing.assert_array_equal(getattr(taken, field.name), getattr(anew, field.name))
    # another exposure, another video: the tracks are others
    other = replace(options, shutter=Shutter(0.002))
    assert read_watched_tracks(tracks_file, video, neck, other) == {}
    longer = tmp_path / experiment.video.name
    longer.write_bytes(experiment.video.read_bytes() + b"x")
    assert read_watched_tracks(tracks_file, describe_video(longer), neck, options) == {}


def test_an_interrupt_ends_with_the_outcome(begin: Begin) -> None:
    experiment = begin(9.0)
    write = experiment.clock.sleep

    def sleep(seconds: float) -> None:
        if experiment.now_s > 7.5:
            raise KeyboardInterrupt
        write(seconds)

    recording = read_recording(experiment.video.parent, growing=True)
    result = watch(recording, experiment.say, 60.0, None, WallClock(lambda: experiment.now_s, sleep))
    assert result.outcome.clock is not None
    assert experiment.events[-1][1]["event"] == "end"
    assert experiment.now_s < 8

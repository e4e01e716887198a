"""A light that the controller switches: brightness integrated over exposures by the test's own sum over 400 instants."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from identification.dataset.series import Series
from mechanism.description import read_neck
from samples.generator.clocks import clocks, frame_times
from samples.worlds.clock_worlds import NECK_FILE, arm, clock_recording, switched_light
from synchronisation.angles import Angles, read_angles, write_angles
from synchronisation.clocks.clock import fit_clock
from synchronisation.clocks.light import edges_of, fit_light
from synchronisation.encoder_log import read_log
from vision.light_patch import LightPatch
from vision.shutter import Shutter
from xneck.recording.recording_folder import read_recording
from xneck_foundation.errors import Refused

EXPOSURE = 0.004


def errors_of_light(seed: int) -> tuple[float, float, float, float]:
    """Errors of offset and skew, and their sigmas."""
    rng = np.random.default_rng([seed, 5])
    times = frame_times(60.0, rng)
    true = clocks(times, rng)
    light = switched_light(true, times, seed)
    clock = fit_light(*edges_of(light.time, light.led), times, light.brightness, EXPOSURE)
    offset = true.offset_s + true.skew * (clock.middle - true.middle_s)
    return clock.offset - offset, clock.skew - true.skew, clock.offset_sigma, clock.skew_sigma


def test_a_light_tells_offset_and_skew_to_a_tenth_of_a_millisecond() -> None:
    """About 12 of 100 changes fall into an exposure of 4 ms; with 2 % of noise each is worth 0.08 ms, all together 0.03 ms.
    40 seeds: the rms of z of a normal lies within 0.7 to 1.3 with 99 % probability."""
    found = np.array([errors_of_light(seed) for seed in range(40)])
    assert np.max(np.abs(found[:, 0])) < 0.1e-3
    assert np.max(np.abs(found[:, 1])) < 10e-6
    for error, sigma in ((0, 2), (1, 3)):
        assert 0.7 < np.sqrt(np.mean((found[:, error] / found[:, sigma]) ** 2)) < 1.3


def test_light_that_contradicts_the_log_or_cannot_be_seen_is_refused() -> None:
    times = frame_times(60.0, np.random.default_rng(1))
    true = clocks(times, np.random.default_rng(2))
    light, other = switched_light(true, times, 1), switched_light(true, times, 2)
    edges = edges_of(light.time, light.led)
    with pytest.raises(Refused, match="not the one in the log"):
        fit_light(*edges, times, other.brightness, EXPOSURE)
    with pytest.raises(Refused, match="does not stand out"):
        fit_light(*edges, times, 100 + np.random.default_rng(3).normal(0, 2, len(times)), EXPOSURE)
    with pytest.raises(Refused, match="changes 3 times"):
        fit_light(edges[0][:3], edges[1], times, light.brightness, EXPOSURE)


def lit_recording(delay: float = 0.0) -> tuple[Angles, Series, float]:
    """A recording whose log holds `led` and whose angles hold the light, its patch exposed `delay` s after the middle row."""
    made = clock_recording("damped cables", 102, 20.0)
    angles = made.angles
    light = switched_light(made.clocks, angles.time + delay, 102, 40, EXPOSURE, made.log.time)
    notes = {"light": {"exposure_s": EXPOSURE, "later_s": delay}}
    log = Series(made.log.time, {**made.log.columns, "led": light.led})
    return replace(angles, light=light.brightness, notes=notes), log, made.clocks.offset_s


def test_the_clock_rests_on_the_light_where_there_is_one() -> None:
    """And keeps beside it what cables and arm say; the two agree."""
    for delay in (0.0, 0.008):
        angles, log, offset = lit_recording(delay)
        clock = fit_clock(arm(), angles, log)
        assert clock.source == "light"
        assert abs(clock.offset - offset) < 4 * clock.offset_sigma < 0.8e-3
        assert clock.motion_offset is not None
        assert abs(clock.motion_offset[0] - clock.offset) < 4 * np.hypot(clock.motion_offset[1], clock.offset_sigma)
        assert not clock.warnings


def test_a_light_serves_an_arm_at_rest_too() -> None:
    angles, log, offset = lit_recording()
    still = replace(angles, alpha=angles.alpha * 0 + 0.1)
    clock = fit_clock(arm(), still, log)
    assert clock.source == "light"
    assert clock.motion_offset is None
    assert abs(clock.offset - offset) < 4 * clock.offset_sigma


def test_cables_that_disagree_with_the_light_are_reported() -> None:
    """Angles 3 ms late against the light."""
    angles, log, _ = lit_recording(0.003)
    wrong = replace(angles, notes={"light": {"exposure_s": EXPOSURE, "later_s": 0.0}})
    assert any("away from the light" in word for word in fit_clock(arm(), wrong, log).warnings)


def test_a_patch_is_read_where_it_is_and_when_its_rows_are_exposed() -> None:
    grey = np.zeros((480, 640), dtype=np.uint8)
    grey[100:110, 200:220] = 80
    patch = LightPatch(200, 100, 20, 10)
    assert patch.brightness(grey) == 80
    assert LightPatch(210, 100, 20, 10).brightness(grey) == 40
    # rows 100..109 lie 135 rows above the middle between rows 239 and 240
    assert patch.delay_s(480, Shutter(row_s=1e-5)) == pytest.approx(-135e-5)
    with pytest.raises(Refused, match="reaches"):
        patch.refuse_outside(210, 480, "video")


def test_the_light_of_a_log_and_its_place_in_a_recording_are_read(tmp_path: Path) -> None:
    neck = read_neck(NECK_FILE)
    names = [f"{stem}{j + 1}" for stem in ("theta", "f") for j in range(4)]
    rows = [",".join(["time", *names, "led"])] + [
        ",".join([str(0.002 * k), *["1.5"] * 8, str(k % 2)]) for k in range(9)
    ]
    path = tmp_path / "log.csv"
    path.write_text("\n".join([*rows, ""]))
    np.testing.assert_array_equal(read_log(path, neck).columns["led"], np.arange(9) % 2)
    path.write_text("\n".join([*rows[:-1], rows[-1][:-1] + "7", ""]))
    with pytest.raises(Refused, match="led is neither 0 nor 1 in row 10"):
        read_log(path, neck)
    (tmp_path / "neck.yaml").write_text(NECK_FILE.read_text())
    for name in ("video.mp4", "camera.yaml"):
        (tmp_path / name).touch()
    config = tmp_path / "recording.yaml"
    named = "video: video.mp4\ncamera: camera.yaml\nlog: log.csv\nneck: neck.yaml\n"
    config.write_text(named + "anchor: {x: 3, y: 4, width: 5, height: 6}\n")
    assert read_recording(tmp_path).light == LightPatch(3, 4, 5, 6)
    config.write_text(named)
    assert read_recording(tmp_path).light is None


def test_the_light_goes_with_the_angles_through_their_files(tmp_path: Path) -> None:
    angles, _, _ = lit_recording()
    quality = Series(angles.time, {"residual_px": angles.time * 0, "light": np.asarray(angles.light)})
    write_angles(angles, tmp_path / "a.mcap", quality)
    back = read_angles(tmp_path / "a.mcap", 3)
    np.testing.assert_array_equal(back.light, angles.light)
    assert back.notes["light"] == angles.notes["light"]


@pytest.mark.parametrize("disturbed", [0.0, 0.2])
def test_brightness_that_does_not_follow_the_exposure_widens_the_sigma(disturbed: float) -> None:
    """Frames that a switch fell into, whose brightness is off by 0.2 of the contrast, ten times the noise that shows elsewhere:
    the errors grow with it and so must the sigmas. 30 seeds: the rms of z of a normal lies within 0.65 to 1.4 by 99 %; a
    heavy-tailed rest is allowed twice as far down."""
    z = []
    for seed in range(30):
        rng = np.random.default_rng([seed, 6])
        times = frame_times(40.0, rng)
        true = clocks(times, rng)
        light = switched_light(true, times, seed)
        off, on = np.percentile(light.brightness, [5, 95])
        level = (light.brightness - off) / (on - off)
        partly = (level > 0.1) & (level < 0.9)
        brightness = light.brightness + np.where(partly, disturbed * (on - off) * rng.normal(size=len(times)), 0.0)
        clock = fit_light(*edges_of(light.time, light.led), times, brightness, EXPOSURE)
        offset = true.offset_s + true.skew * (clock.middle - true.middle_s)
        z.append((clock.offset - offset) / clock.offset_sigma)
    assert 0.35 < np.sqrt(np.mean(np.square(z))) < 1.4

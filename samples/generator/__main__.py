"""Makes everything in samples/ anew: python -m samples.generator --seed 1"""

import argparse
from pathlib import Path

import numpy as np
import yaml

from samples.generator.files import write_angles_csv, write_log_csv, write_log_mcap
from samples.generator.recording import Recording, record
from samples.generator.truth import add_scalars, write_truth

_SAMPLES = Path(__file__).resolve().parents[1]
_VIDEO_S = 24.0
_HELD_OUT_S = 20.0
_HELD_OUT_SIGMA = np.radians(0.05)
"""rad, white noise of the held-out angles"""


def main() -> None:
    """Command line of the generator."""
    parser = argparse.ArgumentParser(prog="python -m samples.generator", description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=("log", "video", "board"), help="logs and truth, or video, or board pictures")
    parser.add_argument("--out", type=Path, default=_SAMPLES, help="folder with recording/ and held_out/")
    parser.add_argument("--processes", type=int, default=1, help="for the video; changes its time only")
    chosen = parser.parse_args()
    if chosen.only != "board":
        main_recording = _recording(chosen.out / "recording", _VIDEO_S, [chosen.seed, 0])
        if chosen.only != "video":
            _write_logs(chosen.out, chosen.seed, main_recording)
        if chosen.only != "log":
            _write_video(chosen.out / "recording", chosen.seed, main_recording, chosen.processes)
    if chosen.only in (None, "board"):
        _write_board(chosen.out, chosen.seed)


def _recording(folder: Path, duration: float, seed: list[int]) -> Recording:
    return record(yaml.safe_load((folder / "neck.yaml").read_text(encoding="utf-8")), duration, seed)


def _write_logs(out: Path, seed: int, main_recording: Recording) -> None:
    from samples.generator.camera import SAMPLE_CAMERA

    held_out = _recording(out / "held_out", _HELD_OUT_S, [seed, 1])
    for name, r in (("recording", main_recording), ("held_out", held_out)):
        write_log_mcap(out / name / "log.mcap", r.log_time, r.run.counted, r.run.f)
    run = main_recording.run
    write_log_csv(out / "recording" / "log.csv", main_recording.log_time, run.counted, run.f)
    seen = held_out.alpha_at(held_out.frame_times)
    noise = np.random.default_rng([seed, 2]).normal(0, _HELD_OUT_SIGMA, seen.shape)
    sigma = np.full(seen.shape, _HELD_OUT_SIGMA)
    write_angles_csv(out / "held_out" / "angles.csv", held_out.frame_times, seen + noise, sigma)
    write_truth(out, seed, {"recording": main_recording, "held_out": held_out}, SAMPLE_CAMERA)


def _write_video(folder: Path, seed: int, r: Recording, processes: int) -> None:
    from samples.generator.camera import SAMPLE_CAMERA
    from samples.generator.video import render_video

    neck = yaml.safe_load((folder / "neck.yaml").read_text(encoding="utf-8"))
    render_video(folder / "video.mp4", r.frame_times, r.alpha_at, neck, SAMPLE_CAMERA, seed, processes=processes)


def _write_board(out: Path, seed: int) -> None:
    from samples.generator.board import render_board_pictures
    from samples.generator.camera import SAMPLE_CAMERA

    folder = out / "recording"
    board = yaml.safe_load((folder / "board.yaml").read_text(encoding="utf-8"))
    poses = render_board_pictures(folder / "board", board, SAMPLE_CAMERA, seed)
    add_scalars(out, {"board": poses})


if __name__ == "__main__":
    main()

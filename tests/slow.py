"""Which tests the quick lane leaves out, which are begun first, and which go to one core."""

from pathlib import PurePosixPath

SLOW = (
    "benchmarks/test_clean_arms.py",
    "benchmarks/test_growth.py",
    "benchmarks/test_page.py",
    "benchmarks/test_peers.py",
    "calibration/test_bundle_adjustment.py",
    "calibration/test_camera_check.py",
    "calibration/test_camera_comparison.py",
    "calibration/test_coverage.py",
    "calibration/test_estimation.py",
    "calibration/test_observations.py",
    "calibration/test_real_data.py",
    "calibration/test_rendered_bow.py",
    "calibration/test_sheets.py",
    "diagnosis",
    "discovery/test_discover.py",
    "docs",
    "identification/design",
    "identification/simulation",
    "identification/test_elongation_errors.py",
    "identification/test_estimates.py",
    "identification/test_instruments.py",
    "identification/test_motor_speeds.py",
    "identification/test_pose_calibration.py",
    "identification/test_recovery.py",
    "identification/test_rows.py",
    "mechanism/mjcf/test_document.py",
    "mechanism/test_energy.py",
    "mechanism/test_mujoco_peer.py",
    "mechanism/test_simulation.py",
    "mechanism/test_unlisted_laws.py",
    "observation",
    "packaging/test_skips.py",
    "packaging/test_wheel.py",
    "robustness",
    "samples",
    "state_estimation/test_elongation_law.py",
    "state_estimation/test_fast_motion.py",
    "state_estimation/test_state.py",
    "synchronisation/check",
    "synchronisation/clocks",
    "synchronisation/long",
    "synchronisation/test_alpha_zero.py",
    "synchronisation/test_exchanged_columns.py",
    "synchronisation/test_rates.py",
    "synchronisation/test_wrong_logs.py",
    "test_without_camera.py",
    "vision/linkage",
    "vision/markers",
    "vision/test_extract.py",
    "vision/test_interlacing.py",
    "vision/test_marker_tracks.py",
    "vision/test_planes.py",
    "vision/test_small_overlay.py",
    "xneck/batch",
    "xneck/cli",
    "xneck/export/test_figure_files.py",
    "xneck/export/test_python_face.py",
    "xneck/report",
    "xneck/study/test_run_cases.py",
    "xneck/test_same_bytes.py",
    "xneck/viewers",
    "xneck/watch/test_watch.py",
)
"""files and folders whose tests take more than about seven seconds of one core together: `make check` leaves them to `make test`"""

QUICK = (
    "diagnosis/test_advice.py",
    "diagnosis/test_deciding_motion.py",
    "diagnosis/test_gain_in_model.py",
    "diagnosis/test_joined_stretches.py",
    "diagnosis/test_record.py",
    "diagnosis/test_shown_by.py",
    "identification/design/test_information.py",
    "identification/simulation/test_channels.py",
    "identification/simulation/test_perturbations.py",
    "identification/simulation/test_windows.py",
    "observation/test_frames_on_another_clock.py",
    "observation/test_health_before_gaps.py",
    "synchronisation/clocks/test_light_beside_motion.py",
    "vision/linkage/test_marker_depth.py",
    "xneck/batch/test_recording_troubles.py",
    "xneck/cli/test_design_seed.py",
    "xneck/report/test_batch_table.py",
    "xneck/report/test_recording_tables.py",
)
"""files in those folders whose tests take a second or two"""

LONGEST = (
    "diagnosis",
    "benchmarks/test_growth.py",
    "identification/simulation",
    "mechanism/mjcf",
    "observation",
    "robustness",
    "synchronisation/long",
    "xneck/batch",
    "xneck/cli",
    "xneck/report",
    "xneck/test_same_bytes.py",
    "xneck/watch",
)
"""files, or those that go to one core together, of a minute and more"""

FIRST = "diagnosis/test_hidden_effects.py"
"""what is begun with where time is limited"""

TOGETHER = (
    (
        "diagnosis/test_causes_beside_laws.py",
        "diagnosis/test_found_laws.py",
        "diagnosis/test_friction_curve.py",
        "diagnosis/test_held_at_rest.py",
        "diagnosis/test_hidden_effects.py",
        "diagnosis/test_numbers_of_causes.py",
        "synchronisation/clocks/test_alternative_arms.py",
    ),
    ("docs/test_examples.py", "docs/test_json_keys.py"),
    ("observation",),
    ("samples/forward_arms",),
    ("xneck/batch",),
    ("xneck/report",),
)
"""files and folders whose tests share what takes long to make: on two cores it would be made twice"""


def is_slow(file: str) -> bool:
    """Whether the quick lane leaves a file out, such as `diagnosis/test_record.py`."""
    return file not in QUICK and any(PurePosixPath(file).is_relative_to(place) for place in SLOW)


def together(file: str) -> str:
    """The name under which a file's tests go to one core: the file's own, or that of the first place it shares with others."""
    path = PurePosixPath(file)
    for places in TOGETHER:
        if any(path.is_relative_to(PurePosixPath("tests") / place) for place in places):
            return places[0]
    return file

"""A study that is stopped goes on where it was, and one bad case does not end it."""

import json
from pathlib import Path
from typing import Any

import pytest

import xneck.batch.worker_pool
from tests.command import run
from xneck.batch.worker_pool import worker_pool
from xneck.cli.demo import SAMPLES_FOLDER
from xneck.study.plan import Case
from xneck.study.run_cases import cases_to_run, run_cases, stored_record
from xneck_foundation.source_digest import source_digest

WORDS = ("--effects", "tip_payload", "--seeds", "1", "--first-seed", "7200", "--seconds", "16", "10")
GOOD = Case(kinds=("tip_payload",), seed=7200, manner="rich", size=1.0, noise_deg=0.1, seconds=(16.0, 10.0))
IMPOSSIBLE = Case(kinds=("gremlins",), seed=7200, manner="rich", size=1.0, noise_deg=0.1, seconds=(16.0, 10.0))
SHORT = Case(kinds=(), seed=7200, manner="rich", size=1.0, noise_deg=0.1, seconds=(5.0, 5.0))


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, str]]:
    """The folder of a study of three cases, and what failed of it."""
    out = tmp_path_factory.mktemp("study")
    (out / "cases").mkdir()
    # what a worker that was killed leaves
    (out / "cases" / f".{GOOD.name}.xneck-0a1b2c3d" / "fitted").mkdir(parents=True)
    steps: list[int] = []
    with worker_pool(1, None, out) as client:
        failed = run_cases(
            client,
            [IMPOSSIBLE, GOOD, SHORT],
            SAMPLES_FOLDER,
            out / "cases",
            source_digest(SAMPLES_FOLDER / "generator"),
            False,
            steps.append,
        )
    assert steps == [1, 1, 1]
    return out, failed


def test_a_case_that_fails_is_told_and_the_others_go_on(study: tuple[Path, dict[str, str]]) -> None:
    out, failed = study
    assert failed.keys() == {IMPOSSIBLE.name}
    assert "ValueError: gremlins is none of" in failed[IMPOSSIBLE.name]
    assert {path.name for path in (out / "cases").iterdir()} == {f"{GOOD.name}.json", f"{SHORT.name}.json"}


def test_what_is_refused_is_a_result(study: tuple[Path, dict[str, str]]) -> None:
    refused = stored_record(SHORT, study[0] / "cases")
    assert refused is not None
    assert "diagnosis" not in refused
    assert str(study[0]) not in refused["refused"]


def test_done_cases_are_not_run_again_unless_something_changed(
    study: tuple[Path, dict[str, str]], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    out, _ = study
    code = source_digest(SAMPLES_FOLDER / "generator")
    assert cases_to_run([GOOD, IMPOSSIBLE], out / "cases", code) == (IMPOSSIBLE,)
    assert cases_to_run([GOOD], out / "cases", "other code") == (GOOD,)

    def started(*_: Any) -> None:
        raise AssertionError("workers were started")

    monkeypatch.setattr(xneck.batch.worker_pool, "worker_pool", started)
    done = run(capfd, "study", "--out", out, *WORDS)
    assert done.status == 0, done.err
    assert "1 cases, 1 of them done before; 0 failed" in done.out
    record = json.loads((out / "study.json").read_text())
    (score,) = record["scores"]
    assert score["what"] == "tip_payload"
    assert score["sightings"][0]["first"], "named, even in 16 s"
    assert "| tip_payload | 1 | 1/1 |" in (out / "study.md").read_text()
    with pytest.raises(AssertionError, match="workers were started"):
        run(capfd, "study", "--out", out, *WORDS, "--noise", "0.2")


def test_without_a_checkout_there_is_no_study(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "samples").mkdir()
    refused = run(capfd, "study", "--out", tmp_path / "out", "--samples", tmp_path / "samples")
    assert refused.status == 1
    assert refused.err == (
        f"xneck: {tmp_path / 'samples'}: holds no generator; give the samples folder of a checkout with --samples\n"
    )
    assert not (tmp_path / "out").exists()


def test_wrong_usage(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    for words in (("--jobs", "2", "--cluster", "tcp://x:1"), ("--size", "1", "0.5"), ("--seconds", "3", "60")):
        assert run(capfd, "study", "--out", tmp_path / "out", *words).status == 2
    none = run(capfd, "study", "--out", tmp_path / "out", "--seeds", "0")
    assert (none.status, none.err) == (1, "xneck: study: has no case; give --seeds or --pairs\n")

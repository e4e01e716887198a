"""The demo ends with the verdict: from two recordings to a summary that leads to their reports and to the diagnosis."""

import json
import shutil
from pathlib import Path

import pytest
from playwright.sync_api import Page

from samples.generator.hidden.experiment import hide
from tests.command import Ran, run
from tests.html_page import Elements, check_print, look, watch
from xneck.batch.diagnosis_task import stored_diagnosis
from xneck_foundation.json_text import json_text
from xneck_foundation.whole_file import replacing_any_file, write_text


@pytest.fixture(scope="module")
def samples(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """As samples/ is laid out, without a video: an arm with a load that its description does not know."""
    folder = tmp_path_factory.mktemp("samples")
    hide(["tip_payload"], 7011, folder, seconds=(16.0, 10.0))
    (folder / "fitted").rename(folder / "recording")
    return folder


@pytest.fixture(scope="module")
def out(samples: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("demo") / "out <b> é"


def demo(capfd: pytest.CaptureFixture[str], samples: Path, out: Path) -> Ran:
    return run(capfd, "demo", "--samples", samples, "--out", out, "--json", out.with_suffix(".json"))


def test_it_says_what_the_simulation_gets_wrong(samples: Path, out: Path, capfd: pytest.CaptureFixture[str]) -> None:
    ran = demo(capfd, samples, out)
    assert (ran.status, ran.err) == (0, "")
    assert "cause: The arm carries something at its tip" in ran.out
    told, summary = (json.loads(path.read_text()) for path in (out.with_suffix(".json"), out / "summary.json"))
    assert [cause["effect"] for cause in told["diagnosis"]["causes"]] == ["tip_payload"]
    assert Path(told["diagnosis"]["report"]).is_file()
    assert summary["diagnosis"]["sentence"] == told["diagnosis"]["sentence"]
    assert set(summary["recordings"]) == {"recording", "held_out"}


def test_the_summary_leads_to_it(out: Path, browser_page: Page) -> None:
    summary, diagnosis = out / "summary.html", out / "diagnosis/diagnosis.html"
    told = json.loads((out / "summary.json").read_text())["diagnosis"]
    assert told["sentence"] in Elements(summary.read_text(encoding="utf-8")).text
    look(browser_page, summary, 360)
    check_print(browser_page, summary)
    watched = watch(browser_page)
    browser_page.goto(summary.as_uri())
    browser_page.get_by_role("link", name="The diagnosis").click()
    browser_page.wait_for_url(diagnosis.as_uri())
    assert browser_page.locator("h1").inner_text() == "recording, diagnosed"
    verdict = browser_page.locator("p.verdict").inner_text()
    assert verdict.replace("\N{NO-BREAK SPACE}", " ") == told["sentence"]
    # across to a recording, and up again
    recording = out / "recording/report.html"
    browser_page.get_by_role("link", name="recording", exact=True).click()
    browser_page.wait_for_url(recording.as_uri())
    browser_page.get_by_role("link", name="all recordings").click()
    browser_page.wait_for_url(summary.as_uri())
    watched.check([summary, diagnosis, recording])


def test_once_more_it_does_nothing_and_other_data_are_diagnosed_anew(
    samples: Path, out: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    record = out / "diagnosis/diagnosis.json"
    before, when = record.read_text(), record.stat().st_mtime_ns
    assert demo(capfd, samples, out).out.count("done before") == 2
    assert record.stat().st_mtime_ns == when
    older = json.loads(before)
    older["made_from"]["source"] = "another"
    del older["written_by"]
    with replacing_any_file():
        write_text(record, json_text(older))
    assert stored_diagnosis(record.parent, [out / "recording/dataset.mcap"], [out / "held_out/dataset.mcap"]) is None
    other = tmp_path / "samples"
    shutil.copytree(samples, other)
    log = other / "held_out/log.csv"
    log.write_text("\n".join(log.read_text().splitlines()[:-500]) + "\n")
    assert demo(capfd, other, out).status == 0
    assert json.loads(record.read_text())["made_from"]["inputs"] != older["made_from"]["inputs"]

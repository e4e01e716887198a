"""Figures of a record of benchmarks: single numbers for the text of pages, and the tables of benchmarks/results.md."""

from collections.abc import Iterable, Mapping
from typing import Any

from benchmarks.figures.benchmark_record import claims_of
from benchmarks.summary import HEAD, figure, named
from benchmarks.table import Claim


class Claims:
    """The record's claims, looked up by parts of their words."""

    def __init__(self, topics: Mapping[str, dict[str, Any]]) -> None:
        self._claims = claims_of(topics)

    def all(self, topic: str, what: str = "", on: str = "", peer: str = "") -> list[Claim]:
        """Every claim of a topic in whose words these are. Raises LookupError where there is none."""
        found = [
            claim
            for name, claim in self._claims
            if name == topic and what in claim.what and on in claim.on and peer in (claim.peer or ("",))[0]
        ]
        if not found:
            raise LookupError(f"the record of benchmarks has no claim of {topic} on {what!r}, {on!r}, {peer!r}")
        return found

    def one(self, topic: str, what: str = "", on: str = "", peer: str = "") -> Claim:
        """The first of them."""
        return self.all(topic, what, on, peer)[0]


def benchmark_figures(topics: Mapping[str, dict[str, Any]]) -> dict[str, str]:
    """By name of the figure."""
    claims = Claims(topics)
    return _angles(claims) | _clock(claims) | _estimates(claims) | _computing(claims) | _tables(topics)


def _angles(claims: Claims) -> dict[str, str]:
    edges, grey = (
        claims.one("extraction", "error of an angle, corners from " + words) for words in ("edges", "all grey")
    )
    tags, worst = (claims.one("real_markers", words, peer="pyapriltags") for words in ("tags missed", "worst corner"))
    hard = claims.one("hard")
    return {
        "extraction.angle_deg": _digits(grey.ours, 2),
        "extraction.angle_edges_deg": _digits(edges.ours, 2),
        "extraction.angle_opencv_deg": _digits(_peer(claims.one("extraction", "error of an angle", peer="OpenCV")), 2),
        "extraction.decodings": _digits(claims.one("extraction", "time of a frame, corners from all grey").ours),
        "extraction.decodings_edges": _digits(claims.one("extraction", "time of a frame, corners from edges").ours),
        "markers.ideal_bounds": _span(c.ours for c in claims.all("markers", on="ideal")),
        "markers.opencv_bounds": _span(_peer(c) for c in claims.all("markers", on="ideal", peer="SUBPIX")),
        "markers.pyapriltags_bounds": _span(_peer(c) for c in claims.all("markers", on="ideal", peer="pyapriltags")),
        "markers.jpeg_bounds": _span(c.ours for c in claims.all("markers", on="JPEG")),
        "hard.lost": f"{_needed(hard.ours):.0f}",
        "hard.lost_opencv": f"{_peer(hard):.0f}",
        "real_markers.missed": f"{_needed(tags.ours):.0f}",
        "real_markers.missed_apriltag": f"{_peer(tags):.0f}",
        "real_markers.corner_ratio": _digits(worst.ratio),
        "calibration.fit_ratio": _span(c.ratio for c in claims.all("calibration", "time of one fit")),
        "calibration.all_ratio": _span(c.ratio for c in claims.all("calibration", "time of all")),
        "calibration.bowed_held_out_px": _digits(claims.one("calibration", "held out", "bowed").ours, 2),
        "calibration.bowed_held_out_opencv_px": _digits(_peer(claims.one("calibration", "held out", "bowed")), 2),
    }


def _clock(claims: Claims) -> dict[str, str]:
    offsets = claims.all("clock", "error of the offset")
    return {
        "clock.offset_ms": _span(c.ours for c in offsets),
        "clock.offset_limit_ms": _span(c.limit[1] for c in offsets if c.limit),
        "clock.offset_correlation_ms": _span(_peer(c) for c in offsets),
        "clock.recordings": offsets[0].on.split(",")[0],
        "lost_frames.wrong_percent": _digits(claims.one("lost_frames").ours, 2) + " %",
    }


def _estimates(claims: Claims) -> dict[str, str]:
    recordings = "recordings of"
    figures = {}
    for term in ("fs", "k", "ca"):
        known = claims.one("identification", f"error of {term},", recordings)
        not_known = claims.one("identification", f"error of {term},", "pre-elongation not described")
        figures |= {
            f"identification.{term}": _digits(known.ours, 2) + " %",
            f"identification.{term}_fasquelle": _digits(_peer(known), 2) + " %",
            f"identification.{term}_unknown_x0": _digits(not_known.ours, 2) + " %",
            f"identification.{term}_fasquelle_unknown_x0": _digits(_peer(not_known), 2) + " %",
        }
    for derivative, name in (("alpha,", "angle"), ("alpha',", "rate"), ("alpha'',", "acceleration")):
        figures[f"state.{name}_ratio"] = _span(c.ours for c in claims.all("state", f"error of {derivative}"))
    return figures | {
        "identification.recordings": claims.one("identification", on=recordings).on,
        "check.healthy_blamed": _digits(claims.one("check", "healthy").ours) + " %",
        "check.not_named": _digits(claims.one("check", "not named").ours) + " %",
        "check.recordings": claims.one("check").on,
        "simulation_error.ratio": _span(c.ours for c in claims.all("simulation_error")),
    }


def _computing(claims: Claims) -> dict[str, str]:
    single, many = (claims.one("simulation", on=on) for on in ("1 sets", "1000 sets"))
    figures = {
        "simulation.single_ratio": _digits(single.ratio, 2),
        "simulation.many_ratio": f"{1 / _needed(many.ratio):.0f}",
        "simulation.many_real_time": f"{1000 / _needed(many.ours):.0f}",
        "growth.extract_ratio": _digits(claims.one("growth", "extract: ms").ratio, 2),
    }
    for stage in ("extract", "sync", "check", "identify", "diagnose"):
        time, memory = claims.one("growth", f"{stage}: ms"), claims.one("growth", f"{stage}: peak")
        minutes = _minutes(memory.on) - _minutes((memory.peer or ("",))[0])
        figures |= {
            f"growth.{stage}_on": memory.on,
            f"growth.{stage}_share": f"{_needed(time.ours) / 1000:.2g}",
            f"growth.{stage}_mb": f"{_needed(memory.ours):.0f}",
            f"growth.{stage}_mb_per_minute": f"{(_needed(memory.ours) - _peer(memory)) / minutes:.0f}",
        }
    return figures


def _tables(topics: Mapping[str, dict[str, Any]]) -> dict[str, str]:
    rows = [
        (f"{topic}: {c.what}", figure(c.ours), named(c.peer), figure(c.ratio), named(c.limit), c.on)
        for topic, c in claims_of(topics)
    ]
    lines = [f"| {' | '.join(row)} |" for row in (HEAD, ("---", "---:", "---:", "---:", "---:", "---"), *rows)]
    return {"benchmarks.table": "\n".join(["", *lines, ""]), "benchmarks.made_by": _made_by(topics)}


def _made_by(topics: Mapping[str, dict[str, Any]]) -> str:
    """Topics that were measured on the same day, machine and commit, a line each."""
    groups: dict[tuple[str, str, str], list[str]] = {}
    for name, topic in topics.items():
        m = topic["machine"]
        libraries = ", ".join(f"{key} {version}" for key, version in m["libraries"].items())
        machine = f"{m['processor']}, {m['cores']} cores, Python {m['python']}, {libraries}"
        groups.setdefault((topic["date"][:10], topic["commit"] or "not known", machine), []).append(name)
    lines = [
        f"- {', '.join(names)}: {date}, commit {commit}, {machine}."
        for (date, commit, machine), names in groups.items()
    ]
    return "\n".join(["", *lines, ""])


def _span(values: Iterable[float | None], digits: int = 2) -> str:
    """The least and the largest, or one number where both read alike."""
    known = [value for value in values if value is not None]
    low, high = _digits(min(known), digits), _digits(max(known), digits)
    return low if low == high else f"{low} to {high}"


def _digits(value: float | None, digits: int = 3) -> str:
    known = _needed(value)
    text = f"{known:.{digits}g}"
    return f"{known:.0f}" if "e" in text and known >= 1 else text


def _peer(claim: Claim) -> float:
    return _needed(claim.peer[1] if claim.peer else None)


def _needed(value: float | None) -> float:
    if value is None:
        raise LookupError("the record of benchmarks lacks a number that a page shows")
    return value


def _minutes(words: str) -> float:
    """Of `20 s` or `2 min`."""
    value, unit = words.split()
    return float(value) / (60 if unit == "s" else 1)

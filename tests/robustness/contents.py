"""Files that are whole, with valid checksums, and whose contents make no sense."""

import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from hypothesis import strategies as st
from mcap.writer import CompressionType, Writer

from identification.files.joint_state import DEFINITION

NUMBER = st.one_of(
    st.sampled_from(
        [0.0, -0.0, 1.0, -1.0, float("nan"), float("inf"), -float("inf"), 1e308, -1e308, 5e-324, 1e9, 1e18, 2.0**53]
    ),
    st.floats(-1e3, 1e3),
)
ANY_JSON: st.SearchStrategy[Any] = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(-(2**70), 2**70), NUMBER, st.text(max_size=8)),
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(st.text(max_size=6), inner, max_size=4)),
    max_leaves=12,
)
NAME = st.one_of(
    st.sampled_from(
        ["motor1", "motor2", "motor3", "motor4", "led", "alpha1", "", "\0", "é", "a\nb", "x" * 300, "\x1b[31m"]
    ),
    st.text(max_size=5),
)
SECONDS = st.one_of(st.integers(0, 100), st.sampled_from([-(2**31), -1, 2**31 - 1, 0]))
NANOSECONDS = st.one_of(st.integers(0, 10**9 - 1), st.sampled_from([0, 10**9, 2**32 - 1]))


def cdr(names: list[str], stamp: tuple[int, int], blocks: list[list[float]], frame: str = "") -> bytes:
    """A JointState in little-endian CDR, with as many positions, velocities and efforts as are given."""
    body = bytearray()

    def align(to: int) -> None:
        body.extend(bytes(-len(body) % to))

    def put_text(text: str) -> None:
        raw = text.encode("utf-8", "surrogatepass") + b"\0"
        align(4)
        body.extend(struct.pack("<I", len(raw)) + raw)

    body.extend(struct.pack("<iI", *stamp))
    put_text(frame)
    align(4)
    body.extend(struct.pack("<I", len(names)))
    for name in names:
        put_text(name)
    for block in blocks:
        align(4)
        body.extend(struct.pack("<I", len(block)))
        if block:
            align(8)
        body.extend(struct.pack(f"<{len(block)}d", *block))
    return b"\x00\x01\x00\x00" + bytes(body)


@st.composite
def joint_states(draw: st.DrawFn) -> Callable[[Path], None]:
    """An MCAP of JointState messages of one or two topics: counts that differ, names twice, stamps of all kinds, any JSON."""
    as_json = draw(st.booleans())
    packed = draw(st.sampled_from(list(CompressionType)))
    topics = []
    for _ in range(draw(st.integers(1, 2))):
        names = [f"motor{k + 1}" for k in range(4)]
        if not draw(st.integers(0, 3)):
            names = draw(st.lists(NAME, max_size=6))
        ordered, count = draw(st.booleans()), draw(st.integers(1, 12))
        messages = []
        for k in range(count):
            stamp = (k, 0) if ordered else (draw(SECONDS), draw(NANOSECONDS))
            sizes = (
                [len(names)] * 3
                if draw(st.integers(0, 9))
                else draw(st.lists(st.integers(0, 7), min_size=3, max_size=3))
            )
            blocks = [[draw(NUMBER) for _ in range(size)] for size in sizes]
            own = names if draw(st.integers(0, 9)) else draw(st.lists(NAME, max_size=6))
            if not as_json:
                messages.append(cdr(own, stamp, blocks, draw(st.sampled_from(["", "base", "\xff" * 5]))))
                continue
            row: dict[str, Any] = dict(zip(("position", "velocity", "effort"), blocks, strict=True))
            row |= {"name": own, "header": {"stamp": {"sec": stamp[0], "nanosec": stamp[1]}}}
            if not draw(st.integers(0, 3)):
                row[draw(st.sampled_from([*row, "stamp"]))] = draw(ANY_JSON)
            text = json.dumps(draw(ANY_JSON) if not draw(st.integers(0, 19)) else row)
            messages.append(text.encode())
        topics.append(messages)

    def written(path: Path) -> None:
        with path.open("wb") as stream:
            writer = Writer(stream, compression=packed)
            writer.start(profile="ros2")
            encoding = ("jsonschema", b"{}") if as_json else ("ros2msg", DEFINITION.encode())
            schema = writer.register_schema("sensor_msgs/msg/JointState", *encoding)
            for t, messages in enumerate(topics):
                channel = writer.register_channel(f"/joints{t}", "json" if as_json else "cdr", schema)
                for k, message in enumerate(messages):
                    writer.add_message(channel, k * 2_000_000, message, k * 2_000_000, k)
            writer.finish()

    return written


@st.composite
def tables(draw: st.DrawFn) -> Callable[[Path], None]:
    """A CSV of whole rows: columns of a log or of angles in any order, some missing, more or twice; numbers of any size."""
    known = draw(st.sampled_from([["alpha", "sigma"], ["theta", "f"]]))
    header = ["time", *(f"{stem}{k + 1}" for stem in known for k in range(4)), "led", "common1", "", "Time"]
    names = draw(st.permutations(header))[: draw(st.integers(1, len(header)))]
    if draw(st.booleans()):
        names = ["time", *(name for name in header[1:9])]
    separator = draw(st.sampled_from([",", ",", ",", ";", "\t", ", "]))
    rows, step = draw(st.integers(0, 40)), draw(st.sampled_from([0.002, 1 / 30, 1.0, 2.0, 1e6, 1e-9, 0.0, -1.0]))
    value, odd = draw(NUMBER), draw(st.tuples(st.integers(0, 39), st.integers(0, 20), NUMBER))
    rng = np.random.default_rng(draw(st.integers(0, 99)))

    def written(path: Path) -> None:
        table = rng.normal(0, 1, (rows, len(names))) * (value if np.isfinite(value) and abs(value) < 1e300 else 1.0)
        if "time" in names:
            table[:, names.index("time")] = step * np.arange(rows)
        if rows:
            table[odd[0] % rows, odd[1] % len(names)] = odd[2]
        lines = [separator.join(names), *(separator.join(map(repr, row)) for row in table.tolist())]
        path.write_text("\n".join(lines) + "\n")

    return written


@st.composite
def pictures(draw: st.DrawFn) -> Callable[[bytes], tuple[str, bytes]]:
    """From a photograph of a board another whole picture file, by suffix and content: of any size, depth, place and light."""
    suffix = draw(st.sampled_from([".png", ".png", ".jpg", ".bmp", ".tif", ".webp", ".pgm"]))
    kind = draw(
        st.sampled_from(
            ["as it is", "inverted", "mirrored", "turned", "flat", "noise", "cut", "stretched", "tiny", "dark"]
        )
    )
    depth = draw(st.sampled_from(["grey", "colour", "alpha", "16 bit"]))
    seed, share = draw(st.integers(0, 99)), draw(st.floats(0.02, 1.0))

    def changed(whole: bytes) -> tuple[str, bytes]:
        grey = cv2.imdecode(np.frombuffer(whole, np.uint8), cv2.IMREAD_GRAYSCALE)
        assert grey is not None
        grey = cv2.resize(grey, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
        height, width = grey.shape
        rng = np.random.default_rng(seed)
        made = {
            "as it is": lambda: grey,
            "inverted": lambda: 255 - grey,
            "mirrored": lambda: grey[:, ::-1],
            "turned": lambda: np.rot90(grey, seed % 4),
            "flat": lambda: np.full_like(grey, seed),
            "noise": lambda: rng.integers(0, 256, grey.shape, np.uint8),
            "cut": lambda: grey[: max(1, int(share * height)), : max(1, int(share * width))],
            "stretched": lambda: cv2.resize(grey, (max(1, int(share * 40)), 400)),
            "tiny": lambda: grey[: 1 + seed % 3, : 1 + seed % 2],
            "dark": lambda: (grey * share * 0.1).astype(np.uint8),
        }[kind]()
        picture: np.ndarray = np.ascontiguousarray(made)
        if depth == "16 bit" and suffix in (".png", ".tif", ".pgm"):
            picture = picture.astype(np.uint16) * 257
        elif depth in ("colour", "alpha") and suffix != ".pgm":
            picture = cv2.cvtColor(
                picture, cv2.COLOR_GRAY2BGRA if depth == "alpha" and suffix == ".png" else cv2.COLOR_GRAY2BGR
            )
        done, coded = cv2.imencode(suffix, picture)
        assert done
        return suffix, coded.tobytes()

    return changed

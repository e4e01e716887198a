"""Frames in which another print of a marker may have been followed in its place.

A marker's id may be in view on a second print: on a spare sheet, on another arm. While both are seen neither is believed. Where one
alone is seen it need not be the one that was followed before: that one may be hidden. Sightings are therefore given to prints: each
to the print that can have come from its last place to where it is seen now, and to a new print where none can.

Which of several prints is meant is told by the reach of the arm where there is one, else by what was followed before a second print
came into view. Where neither tells, all are left out.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from vision.markers.tracking import OTHER_PRINT, TRACKED
from vision.markers.video_tracking import MarkerTracks

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

MARGIN_SIDES = 1.5
"""sides of a marker by which its place may differ from the predicted one, however short the time (docs/thresholds.md)"""
MAX_ACCELERATION_SIDES = 3000.0
"""sides of a marker/s^2: no arm accelerates its markers by more (docs/thresholds.md)"""
MAX_SPEED_SIDES = 150.0
"""sides of a marker/s that it moves by at most, where no sighting before the last one tells how fast it was (docs/thresholds.md)"""
STANDING_SIDES = 0.5
"""sides of a marker around the last place of a print, within which a sighting is of that print (docs/thresholds.md)"""
MAX_OVER_REACH = 1.3
"""distance from another marker over the arm's reach, beyond which a print is not on the arm (docs/thresholds.md)"""
MIN_SHARE_IN_REACH = 0.9
"""share of a print's sightings that are within the arm's reach, from which on it may be on the arm (docs/thresholds.md)"""
MAX_PREDICTION_S = 0.2
"""s from one sighting to the next, up to which they tell where the marker is going (docs/thresholds.md)"""


@dataclass(frozen=True)
class LeftOut:
    """Frames of one marker in which another print of it may have been followed."""

    marker: int
    """its index"""
    frames: NDArray[np.intp]
    jump_px: float
    """from the last place of the print that is meant to the first of these sightings; NaN where nothing tells which is meant"""


@dataclass
class _Print:
    """The sightings of one print of a marker so far."""

    frames: list[int] = field(default_factory=list)
    places: list[Array] = field(default_factory=list)
    """(2,), px"""
    is_alone: list[bool] = field(default_factory=list)
    """whether no other print of the marker is seen in the frame"""

    def lone_frames(self, before: float = np.inf) -> NDArray[np.intp]:
        """Frames before a certain one that show no other print."""
        frames = np.array(self.frames, dtype=np.intp)
        return frames[np.array(self.is_alone, dtype=bool) & (frames < before)]


def second_prints(
    time: Array, corners: Array, status: NDArray[np.int8], prints: Array, reach: Array | None
) -> list[LeftOut]:
    """What is left out of the tracks of markers, entry by entry for those of which other prints are in view.

    time: (F,), s; corners: (F, markers, 4, 2), px; status: (F, markers); prints: (n, 4); all as in `MarkerTracks`.
    reach: (markers, markers), largest distance of two markers, in sides of a marker; None without an arm.
    """
    middles = corners.mean(axis=2)
    sides = np.linalg.norm(np.roll(corners, -1, axis=2) - corners, axis=-1).mean(axis=-1)
    markers = range(middles.shape[1])
    jumped = np.stack([_jumps(time, middles[:, k], sides[:, k]) for k in markers], axis=1)
    # where most markers jump at once, the camera was knocked or the video is cut
    found = np.count_nonzero(~np.isnan(sides), axis=1)
    is_cut = (found > 1) & (jumped.sum(axis=1) > found / 2)
    left_out = []
    for k in markers:
        doubled = prints[prints[:, 1] == k]
        if not (len(doubled) or (jumped[:, k] & ~is_cut).any()):
            continue
        seen = _sorted_by_print(time, middles[:, k], sides[:, k], status[:, k], doubled, is_cut)
        entry = _left_out(k, seen, _meant(seen, middles, sides, k, reach))
        left_out += [entry] if len(entry.frames) else []
    return left_out


def without_second_prints(tracks: MarkerTracks, left_out: Sequence[LeftOut]) -> MarkerTracks:
    """The tracks without the frames that are left out."""
    frames = np.zeros(tracks.status.shape, dtype=bool)
    for entry in left_out:
        frames[entry.frames, entry.marker] = True
    return tracks.without(frames, OTHER_PRINT)


def second_print_warnings(time: Array, left_out: Sequence[LeftOut], ids: Sequence[int]) -> list[str]:
    """A sentence for each marker of which frames are left out; time: (F,), s; ids: of all markers."""
    sentences = []
    for entry in left_out:
        where = f"{len(entry.frames)} of {len(time)} frames, first at {time[entry.frames[0]]:.2f} s"
        shown = (
            f"two prints of it are in view, and nothing tells which is meant: left out where one is seen alone ({where})"
            if np.isnan(entry.jump_px)
            else f"another print of it is seen alone, {entry.jump_px:.0f} px from where the marker was: left out ({where})"
        )
        sentences.append(f"marker {ids[entry.marker]}: {shown}; cover the other print, or take it away")
    return sentences


def _gate(side: Array | float, since: Array | float, before: Array | float) -> Array | float:
    """How far from its predicted place a marker can be, px, s since its last sighting, which was s after the one before.

    The line through two sightings is off by the acceleration over since (since + before) / 2. NaN: there was none before.
    """
    speed = np.where(np.isnan(before), MAX_SPEED_SIDES, 0.0)
    of_acceleration = MAX_ACCELERATION_SIDES * since * (since + np.nan_to_num(before)) / 2
    return side * (MARGIN_SIDES + speed * since + of_acceleration)


def _jumps(time: Array, middle: Array, side: Array) -> Mask:
    """Frames (F,) in which a marker is further from where it was going than it can have come."""
    jumped = np.zeros(len(time), dtype=bool)
    at = np.flatnonzero(~np.isnan(side))
    if len(at) < 2:
        return jumped
    step, since = np.diff(middle[at], axis=0), np.diff(time[at])
    before = np.append(np.nan, since[:-1])
    before[np.fmax(since, before) > MAX_PREDICTION_S] = np.nan
    ahead = np.nan_to_num(np.append(np.zeros((1, 2)), step[:-1], axis=0) * (since / before)[:, None])
    off = np.minimum(np.linalg.norm(step, axis=1), np.linalg.norm(step - ahead, axis=1))
    jumped[at[1:]] = off > _gate(side[at[1:]], since, before)
    return jumped


def _sorted_by_print(
    time: Array, middle: Array, side: Array, status: NDArray[np.int8], doubled: Array, is_cut: Mask
) -> list[_Print]:
    """The sightings of one marker, print by print in the order in which they came into view."""
    known_side = np.nanmedian(side) if np.isfinite(side).any() else 0.0
    doubled_frames = np.searchsorted(time, doubled[:, 0])
    begins = np.flatnonzero(~np.isnan(side) & (status != TRACKED))
    seen: list[_Print] = []
    for frame in np.union1d(begins, doubled_frames).tolist():
        gate_side = float(known_side if np.isnan(side[frame]) else side[frame])
        if np.isnan(side[frame]):
            left = list(doubled[doubled_frames == frame, 2:])
            taken: list[_Print] = []
            while left:
                free = [p for p in seen if not any(p is q for q in taken)]
                # the clearest first: a new print may be within reach of one that is seen too
                offs = [min((_off(time, p, frame, place)[0] for p in free), default=np.inf) for place in left]
                place = left.pop(int(np.argmin(offs)))
                of = _print_at(time, free, frame, place, gate_side)
                if of is None:
                    seen.append(of := _Print())
                taken.append(of)
                _add(of, frame, place, alone=False)
            continue
        of = _print_at(time, seen, frame, middle[frame], gate_side)
        if of is None and is_cut[frame] and seen:
            of = max(seen, key=lambda p: p.frames[-1])
        if of is None:
            seen.append(of := _Print())
        end = frame
        while end < len(time) and not np.isnan(side[end]) and (end == frame or status[end] == TRACKED):
            _add(of, end, middle[end], alone=True)
            end += 1
    return seen


def _add(to: _Print, frame: int, place: Array, alone: bool) -> None:
    to.frames.append(frame)
    to.places.append(place)
    to.is_alone.append(alone)


def _off(time: Array, of: _Print, frame: int, place: Array) -> tuple[float, float]:
    """How far a place is from the last one of a print, or from where that was going, px; and s between its last two sightings, NaN
    where these tell no speed."""
    off = float(np.linalg.norm(place - of.places[-1]))
    if len(of.frames) < 2:
        return off, np.nan
    since, before = time[frame] - time[of.frames[-1]], time[of.frames[-1]] - time[of.frames[-2]]
    if max(since, before) > MAX_PREDICTION_S:
        return off, np.nan
    ahead = (of.places[-1] - of.places[-2]) * since / before
    return min(off, float(np.linalg.norm(place - of.places[-1] - ahead))), float(before)


def _print_at(time: Array, prints: Sequence[_Print], frame: int, place: Array, side: float) -> _Print | None:
    """Which of the prints is seen at a place, px: one that was there, else the one seen last of those that can have come there."""
    off = [_off(time, p, frame, place) for p in prints]
    nearest = min(range(len(prints)), key=lambda k: off[k][0], default=None)
    if nearest is None or off[nearest][0] < STANDING_SIDES * side:
        return None if nearest is None else prints[nearest]
    can = [
        (p.frames[-1], -d, k)
        for k, (p, (d, before)) in enumerate(zip(prints, off, strict=True))
        if d < _gate(side, time[frame] - time[p.frames[-1]], before)
    ]
    return prints[max(can)[2]] if can else None


def _meant(seen: list[_Print], middles: Array, sides: Array, marker: int, reach: Array | None) -> _Print | None:
    """The print that is meant, of those that were seen more than once; None where nothing tells."""
    prints = [p for p in seen if len(p.frames) > 1]
    if reach is not None and len(prints) > 1:
        on_arm = [p for p in prints if _share_in_reach(p, middles, sides, marker, reach) >= MIN_SHARE_IN_REACH]
        prints = on_arm or prints
    if len(prints) < 2:
        return prints[0] if prints else None
    first_doubled = min(
        (f for p in seen for f, alone in zip(p.frames, p.is_alone, strict=True) if not alone), default=np.inf
    )
    lone = [len(p.lone_frames(first_doubled)) for p in prints]
    return prints[int(np.argmax(lone))] if max(lone) else None


def _share_in_reach(of: _Print, middles: Array, sides: Array, marker: int, reach: Array) -> float:
    """Share of the sightings of a print, beside each of the other markers, in which the arm can reach from that to this."""
    others = np.arange(middles.shape[1]) != marker
    frames = np.array(of.frames)
    distance = np.linalg.norm(middles[frames][:, others] - np.array(of.places)[:, None], axis=-1)
    over = distance / (sides[frames][:, others] * reach[marker, others])
    known = np.isfinite(over)
    return float(np.mean(over[known] < MAX_OVER_REACH)) if known.any() else 1.0


def _left_out(marker: int, seen: list[_Print], meant: _Print | None) -> LeftOut:
    """What other prints than the one that is meant were followed in; all of them where nothing tells which is meant."""
    others = [p for p in seen if p is not meant and len(p.lone_frames())]
    if not others or (meant is None and all(len(p.frames) < 2 for p in seen)):
        return LeftOut(marker, np.empty(0, dtype=np.intp), np.nan)
    frames = np.sort(np.concatenate([p.lone_frames() for p in others]))
    jump = np.nan
    if meant is not None:
        first = next(p for p in others if frames[0] in p.frames)
        before = [place for f, place in zip(meant.frames, meant.places, strict=True) if f < frames[0]]
        jump = float(np.linalg.norm(first.places[first.frames.index(frames[0])] - (before or meant.places)[-1]))
    return LeftOut(marker, frames, jump)

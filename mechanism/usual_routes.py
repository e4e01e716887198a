"""Routes that are usual for so many mechanisms and cables, so that every joint moves both ways."""

Route = tuple[str, ...]


def usual_routes(mechanisms: int, cables: int) -> tuple[Route, ...]:
    """Routes of the cables, in the order of the motors.

    On the right one cable ends at each mechanism and goes over the struts below it, so that it turns that joint alone. The others
    are on the left: one through all mechanisms, as Fasquelle's arm has it, further ones to mechanisms below, and where there is
    one for each mechanism all over struts. Cables beyond two a mechanism go through all mechanisms, on the right and on the left
    in turn.
    """
    n = mechanisms
    left_ends = min(cables - min(n, cables - 1), n)
    right_ends = min(cables - left_ends, n)
    routes = [_over_struts("strut", "right", end) for end in _ends(n, right_ends)]
    if left_ends == n:
        routes += [_over_struts("strut_mirrored", "left", end) for end in _ends(n, left_ends)]
    else:
        routes += [_through("left", end) for end in _ends(n, left_ends)]
    further = cables - len(routes)
    return (*routes, *(_through(("right", "left")[k % 2], n) for k in range(further)))


def _ends(mechanisms: int, count: int) -> list[int]:
    """The mechanisms, from 1, at which so many cables of a side end, spread from the base up; the last is the uppermost."""
    return [-(-mechanisms * (k + 1) // count) for k in range(count)]


def _over_struts(strut: str, side: str, end: int) -> Route:
    return (*[strut] * (end - 1), side)


def _through(side: str, end: int) -> Route:
    return (*[f"{side}_through"] * (end - 1), side)

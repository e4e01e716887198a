"""Names of a simulation's channels in words."""

_WORDS = {"alpha": "the angle of joint", "theta": "the angle of motor"}


def channel_words(name: str) -> str:
    """`alpha2` as `the angle of joint 2`."""
    stem = name.rstrip("0123456789")
    return f"{_WORDS.get(stem, stem)} {name.removeprefix(stem)}"

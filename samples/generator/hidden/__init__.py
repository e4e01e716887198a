"""Arms drawn at random that hide an effect: files to diagnose, and a truth to compare with.

Laws have other forms than those that are fitted, where an effect may have several: what is right about a cause must not
depend on having guessed its formula.
"""

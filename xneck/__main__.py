"""`python -m xneck`: the same commands where the script is not on the path."""

from xneck.cli import main

main()

"""The arm as MJCF, the text that MuJoCo and tools that read its models take; writing it needs no MuJoCo."""

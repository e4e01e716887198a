"""Files made to use up memory or time are refused before they do, and no path leads out of a recording's folder."""

import os
import resource
import struct
import subprocess
import sys
import zlib
from pathlib import Path

import lz4.frame
import numpy as np
import pytest
import yaml
import zstandard
from mcap.opcode import Opcode
from mcap.records import Chunk
from mcap.writer import CompressionType, Writer

from identification import joint_state
from mechanism.description import read_neck
from tests.robustness.judge import read, run
from tests.robustness.sources import R
from vision.recording import read_recording
from xneck.errors import Refused
from xneck.strict_yaml import load

GIB = 1 << 30

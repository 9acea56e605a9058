from . import plots as plots
from .replay import Replay as Replay

"""Running in: load, flatten, unload, and again, until shakedown."""

from roughcontact.running_in.cycles import run_in
from roughcontact.running_in.record import Cycle, RunIn

__all__ = ["Cycle", "RunIn", "run_in"]

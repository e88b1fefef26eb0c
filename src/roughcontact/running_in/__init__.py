"""Running in: load, flatten, unload, and repeat until shakedown."""

from roughcontact.running_in.cycles import Cycle, RunIn, run_in

__all__ = ["Cycle", "RunIn", "run_in"]

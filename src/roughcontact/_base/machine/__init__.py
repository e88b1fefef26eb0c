"""Memory and threads of the machine."""

from roughcontact._base.machine.memory import available_memory, limit_address_space, limit_of_memory, require_memory
from roughcontact._base.machine.threads import (
    available_threads,
    choose_threads,
    map_tiles,
    share_machine,
    split,
    thread_count,
    threads_for,
    tiles_of,
    use_threads,
)

__all__ = [
    "available_memory",
    "available_threads",
    "choose_threads",
    "limit_address_space",
    "limit_of_memory",
    "map_tiles",
    "require_memory",
    "share_machine",
    "split",
    "thread_count",
    "threads_for",
    "tiles_of",
    "use_threads",
]

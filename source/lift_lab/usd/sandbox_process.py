"""The process that imports files for :mod:`lift_lab.usd.sandbox` and reports the result.

Run as a script. One line of JSON comes in first: where packages are found, and the seconds to wait for work. The
answer to it, and to each request that follows, is one line too. The packages' own ``__init__`` modules are not run:
they import what an import of USD does not need.
"""

from __future__ import annotations

import contextlib
import json
import os
import resource
import signal
import sys
import types
from typing import Any


def main() -> None:
    # Whatever the libraries print goes nowhere; the answers have a descriptor of their own.
    answers = os.fdopen(os.dup(1), "w", encoding="ascii")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    for number in (signal.SIGINT, signal.SIGHUP):  # they are for the process that asks
        signal.signal(number, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, (signal.SIGALRM, signal.SIGPROF))
    _end_quietly()
    setup = json.loads(sys.stdin.readline())
    sys.path[:] = setup["path"]
    for name, folder in setup["packages"].items():
        package = types.ModuleType(name)
        package.__path__ = [folder]
        sys.modules[name] = package
    import lift_lab.usd.api  # noqa: F401  -- before the first request is timed

    answer: dict[str, Any] = {}
    while True:
        print(json.dumps(answer), file=answers, flush=True)
        signal.signal(signal.SIGALRM, lambda *_: os._exit(0))
        signal.setitimer(signal.ITIMER_REAL, setup["idle_s"])
        line = sys.stdin.readline()
        if not line:
            os._exit(0)
        request = json.loads(line)
        _limit_memory(request["memory"])
        _limit_time(request["computing_s"], request["clock_s"])
        answer = import_in_sandbox(request["file"], request["variants"], request["scale"])
        _limit_time(0, 0)


def import_in_sandbox(file: str, variants: dict[str, str] | None, scale: Any) -> dict[str, Any]:
    """Import a file and forget the result.

    Returns:
        ``files``: what the stage was composed of; or ``error``: prim, attribute and reason of a UsdImportError; or
        ``memory``: whether there was too little of it.
    """
    from pxr import Ar

    from lift_lab.usd.api import errors_of_usd, import_stage
    from lift_lab.usd.report import UsdImportError
    from lift_lab.usd.stage import open_stage

    try:
        with errors_of_usd(file):
            stage = open_stage(file, file, variants, scale)
            used = {Ar.SplitPackageRelativePathOuter(layer.realPath)[0] for layer in stage.GetUsedLayers()}
            import_stage(stage, file)
    except MemoryError:
        return {"memory": True}
    except UsdImportError as error:
        return {"error": [error.prim_path, error.attribute, error.reason]}
    return {"files": sorted(used - {""})}


def _limit_time(computing_s: float, clock_s: float) -> None:
    """End this process by a signal, whatever code it is in, after so long; 0 for never."""
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.signal(signal.SIGPROF, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_PROF, computing_s)
    signal.setitimer(signal.ITIMER_REAL, clock_s)


def _limit_memory(size: int) -> None:
    """No more than `size` bytes of memory, mapped files not counted, nor more than the machine has."""
    have = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    hard = resource.getrlimit(resource.RLIMIT_DATA)[1]
    bounds = [bound for bound in (size, have, hard) if bound != resource.RLIM_INFINITY]
    resource.setrlimit(resource.RLIMIT_DATA, (min(bounds), hard))


def _end_quietly() -> None:
    """No core files; and the first to go if the machine runs out of memory."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))
    with contextlib.suppress(OSError), open("/proc/self/oom_score_adj", "w") as score:
        score.write("1000")


if __name__ == "__main__":
    main()

"""Starts the notebooks' kernels as forks of one process that has imported what they import.

To import IPython, matplotlib and spincheck takes some three CPU seconds, in each of two dozen
notebooks. `begin` starts that process, and makes it Jupyter's kernel `python3`: of each
notebook, Jupyter starts this file as a program, which has the process fork and ends with the fork.
"""

import json
import os
import socket
import sys
import threading
from importlib import import_module
from pathlib import Path
from typing import Any

KERNEL = "python3"
#: Not matplotlib.pyplot, which chooses how figures are shown where it is imported.
IMPORTED = (
    "ipykernel.kernelapp",
    "matplotlib.axes",
    "matplotlib.font_manager",
    "scipy.integrate",
    "scipy.spatial.transform",
    "spincheck.reports.interface.single_run",
)


def begin(folder: Path) -> Any:
    """Start the process that is forked, and return it; it ends when its standard input does."""
    import subprocess
    from tempfile import mkdtemp

    kernel = folder / "kernels" / KERNEL
    kernel.mkdir(parents=True, exist_ok=True)
    # A socket's name may have a hundred bytes, fewer than a folder's may.
    address = str(Path(mkdtemp(prefix="kernels-")) / "socket")
    argv = [sys.executable, "-I", "-S", __file__, address, "-f", "{connection_file}"]
    spec = {"argv": argv, "display_name": "Python 3", "language": "python"}
    (kernel / "kernel.json").write_text(json.dumps(spec), encoding="utf-8")
    os.environ["JUPYTER_PATH"] = str(folder)
    warm = subprocess.Popen(
        [sys.executable, __file__, address], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    assert warm.stdout is not None
    if not warm.stdout.readline():
        raise SystemExit("the process that notebooks' kernels are forked from has ended")
    return warm


def serve(address: str) -> None:
    """Import, then fork at each connection; end as soon as standard input does."""
    import selectors
    import shutil

    preload()
    with socket.socket(socket.AF_UNIX) as listening, selectors.DefaultSelector() as selector:
        listening.bind(address)
        listening.listen(64)
        selector.register(listening, selectors.EVENT_READ)
        selector.register(sys.stdin, selectors.EVENT_READ)
        print("ready", flush=True)
        while not any(key.fileobj is sys.stdin for key, _ in selector.select()):
            connection, _ = listening.accept()
            if os.fork() == 0:
                listening.close()
                selector.close()
                run_kernel(connection)
            connection.close()
    shutil.rmtree(Path(address).parent)


def preload() -> None:
    """Import what notebooks import, and load the machine code of an exact motion."""
    # Read when matplotlib is imported, and by a kernel, which sets it, only later.
    os.environ["MPLBACKEND"] = "module://matplotlib_inline.backend_inline"
    for name in IMPORTED:
        import_module(name)
    import spincheck

    spincheck.exact("fast-top").at([0.0, 1.0])


def run_kernel(connection: socket.socket) -> None:
    """Run a kernel in this process, and end it."""
    from ipykernel.kernelapp import IPKernelApp

    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    os.dup2(2, 1)
    call = json.loads(connection.makefile().readline())
    os.environ.clear()
    os.environ.update(call["environment"])
    os.chdir(call["folder"])
    # The program that Jupyter has started is gone: so is this.
    threading.Thread(target=lambda: connection.recv(1) or os._exit(1), daemon=True).start()
    IPKernelApp.launch_instance(argv=call["arguments"])
    sys.exit(0)


def request(address: str, *arguments: str) -> None:
    """Have a kernel forked, and wait for its end."""
    with socket.socket(socket.AF_UNIX) as connection:
        connection.connect(address)
        call = {
            "environment": dict(os.environ),
            "folder": str(Path.cwd()),
            "arguments": arguments,
        }
        connection.sendall(json.dumps(call).encode() + b"\n")
        connection.recv(1)


if __name__ == "__main__":
    (serve if len(sys.argv) == 2 else request)(*sys.argv[1:])

"""Runs the notebooks' kernels and commands as forks of one process that has imported what they do.

To import IPython, matplotlib and spincheck, and to load spincheck's machine code, takes some three
CPU seconds, in each of two dozen notebooks and thirty commands. `begin` starts the process that is
forked, and puts in the place of Jupyter's kernel and of the command `spincheck` a call of this
file: it has that process fork, passes on its arguments, environment and streams, and ends as the
fork does.
"""

import json
import os
import signal
import socket
import sys
import threading
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

#: Not matplotlib.pyplot, which chooses how figures are shown where it is imported.
IMPORTED = (
    "ipykernel.kernelapp",
    "matplotlib.axes",
    "matplotlib.font_manager",
    "scipy.integrate",
    "scipy.spatial.transform",
    "spincheck.reports.cli.app",
    "spincheck.reports.interface.single_run",
)
STREAMS = ("stdin", "stdout", "stderr")


def begin(folder: Path) -> Any:
    """Start the process that is forked, and return it; it ends when its standard input does."""
    import subprocess
    from tempfile import mkdtemp

    # A socket's name may have a hundred bytes, fewer than a folder's may.
    address = str(Path(mkdtemp(prefix="warm-")) / "socket")
    replace_programs(folder, [sys.executable, "-I", "-S", __file__, address])
    warm = subprocess.Popen(
        [sys.executable, __file__, address], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    assert warm.stdout is not None
    if not warm.stdout.readline():
        raise SystemExit("the process that notebooks are forked from has ended")
    return warm


def replace_programs(folder: Path, call: list[str]) -> None:
    """Have Jupyter's kernel and the command found in a folder, as calls of this file."""
    (kernel := folder / "kernels" / "python3").mkdir(parents=True, exist_ok=True)
    argv = [*call, "kernel", "-f", "{connection_file}"]
    spec = {"argv": argv, "display_name": "Python 3", "language": "python"}
    (kernel / "kernel.json").write_text(json.dumps(spec), encoding="utf-8")
    (command := folder / "bin" / "spincheck").parent.mkdir(exist_ok=True)
    words = " ".join(f"'{word}'" for word in [*call, "spincheck"])
    command.write_text(f'#!/bin/sh\nexec {words} "$@"\n', encoding="utf-8")
    command.chmod(0o755)
    os.environ["JUPYTER_PATH"] = str(folder)
    os.environ["PATH"] = f"{command.parent}:{os.environ['PATH']}"


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
        forks = []
        while not any(key.fileobj is sys.stdin for key, _ in selector.select()):
            connection, _ = listening.accept()
            if (fork := os.fork()) == 0:
                listening.close()
                selector.close()
                run(connection)
            forks.append(fork)
            connection.close()
    # Other children may last as long as this process: to compile starts one that guards the rest.
    for fork in forks:
        os.waitpid(fork, 0)
    shutil.rmtree(Path(address).parent)


def preload() -> None:
    """Import what notebooks import, and load the machine code of an exact motion."""
    # Read when matplotlib is imported, and by a kernel, which sets it, only later.
    os.environ["MPLBACKEND"] = "module://matplotlib_inline.backend_inline"
    # Two pages are read side by side, so that a command has one worker.
    os.cpu_count = lambda: 1
    for name in IMPORTED:
        import_module(name)
    import spincheck

    spincheck.exact("fast-top").at([0.0, 1.0])


def run(connection: socket.socket) -> None:
    """Run a program in this process, send its exit code, and end."""
    message, streams, _, _ = socket.recv_fds(connection, 1 << 20, len(STREAMS))
    call = json.loads(message)
    for (stream, name), received in zip(enumerate(STREAMS), streams, strict=True):
        os.dup2(received, stream)
        os.close(received)
        mode = "w" if stream else "r"
        setattr(sys, name, open(stream, mode, buffering=1, closefd=False))  # noqa: SIM115
    os.environ.clear()
    os.environ.update(call["environment"])
    os.chdir(call["folder"])
    program, *sys.argv[1:] = call["words"]
    sys.argv[0] = program
    # The program that asked for this one is gone: so is this.
    threading.Thread(target=lambda: connection.recv(1) or os._exit(1), daemon=True).start()
    code = 0
    try:
        PROGRAMS[program]()
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
    sys.stdout.flush()
    sys.stderr.flush()
    connection.send(bytes([code]))
    sys.exit(code)


def kernel() -> None:
    """Run a notebook's kernel."""
    from ipykernel.kernelapp import IPKernelApp

    # Without the advice to those who start a kernel at a terminal.
    IPKernelApp.launch_instance([*sys.argv[1:], "--log-level=50"])


def spincheck_command() -> None:
    """Run the command line."""
    from spincheck.reports.cli.start import main

    main()


PROGRAMS: dict[str, Callable[[], None]] = {"kernel": kernel, "spincheck": spincheck_command}


def request(address: str, *words: str) -> None:
    """Have a program run in a fork, and end as it does."""
    # Jupyter interrupts a kernel before it ends it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with socket.socket(socket.AF_UNIX) as connection:
        connection.connect(address)
        call = {"environment": dict(os.environ), "folder": str(Path.cwd()), "words": words}
        socket.send_fds(connection, [json.dumps(call).encode()], range(len(STREAMS)))
        code = connection.recv(1)
        connection.recv(1)
    sys.exit(code[0] if code else 1)


if __name__ == "__main__":
    (serve if len(sys.argv) == 2 else request)(*sys.argv[1:])

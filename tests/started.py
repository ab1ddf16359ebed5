"""Programs in Python that begin with the library and Snakemake imported, as forks of a process.

To start Python and to import takes longer than most jobs of a small study. Each run of the
workflow and each of its jobs is a process of its own here too, with its own folder, environment and
output. Tests of the command, of clusters, and of runs that are killed start both anew, as users do.
"""

import atexit
import gc
import os
import pickle
import runpy
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages

SOURCE = Path(__file__).parents[1] / "src"


def run_snakemake(arguments, folder, environment, seed=1):
    """What ``subprocess.run`` returns of ``python -m snakemake`` with these arguments.

    The hashes of strings, and with them the order of sets, depend on the seed.
    """
    server = _server(environment["PYTHONPATH"], seed)
    with tempfile.TemporaryFile("w+") as stdout, tempfile.TemporaryFile("w+") as stderr:
        with _started(server, arguments, folder, environment, stdout, stderr) as running:
            code = running.wait()
        texts = []
        for file in (stdout, stderr):
            file.seek(0)
            texts.append(file.read())
    return subprocess.CompletedProcess(["snakemake", *arguments], code, *texts)


class _Running:
    """A program that has been started: its number, and its end."""

    def __init__(self, connection):
        self._answer = connection.makefile("rb")
        self.pid = self._number()

    def wait(self):
        """Its exit code."""
        return self._number()

    def _number(self):
        line = self._answer.readline()
        assert line, "the process that starts programs has ended"
        return int(line)


@contextmanager
def _started(address, arguments, folder, environment, stdout, stderr):
    with socket.socket(socket.AF_UNIX) as connection:
        connection.connect(address)
        files = [0, stdout.fileno(), stderr.fileno()]
        socket.send_fds(connection, [b"."], files)
        asked = pickle.dumps((list(arguments), str(folder), dict(environment)))
        connection.sendall(len(asked).to_bytes(8) + asked)
        yield _Running(connection)


@cache
def _server(path, seed):
    """The address of a process that forks, with this search path; it ends with this one."""
    folder = tempfile.mkdtemp(prefix="started-")
    address = f"{folder}/socket"
    environment = os.environ | {"PYTHONPATH": path, "PYTHONHASHSEED": str(seed)}
    command = [sys.executable, __file__, address]
    server = subprocess.Popen(
        command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    assert server.stdout.readline() == b"ready\n"

    def end():
        server.stdin.close()
        server.wait()
        shutil.rmtree(folder)

    atexit.register(end)
    return address


def _serve(address):
    """Answer until the standard input ends: in the process of each program, return what it runs."""
    _import_everything()
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(address)
        listener.listen(64)
        os.write(1, b"ready\n")
        server = os.getpid()
        if os.fork() == 0:
            # no more than a watch on the end of the tests
            listener.close()
            sys.stdin.buffer.read()
            if os.getppid() == server:
                os.kill(server, signal.SIGTERM)
            os._exit(0)
        # nobody waits for what attends to the programs
        signal.signal(signal.SIGCHLD, signal.SIG_IGN)
        while True:
            connection, _ = listener.accept()
            if os.fork() == 0:
                listener.close()
                signal.signal(signal.SIGCHLD, signal.SIG_DFL)
                return _attend(connection)
            connection.close()


def _attend(connection):
    """Fork the program, and tell of its end; in its process, return its arguments."""
    _, files, _, _ = socket.recv_fds(connection, 1, 3)
    stream = connection.makefile("rb")
    arguments, folder, environment = pickle.loads(stream.read(int.from_bytes(stream.read(8))))
    program = os.fork()
    if program:
        connection.sendall(b"%d\n" % program)
        _, status = os.waitpid(program, 0)
        connection.sendall(b"%d\n" % os.waitstatus_to_exitcode(status))
        os._exit(0)
    connection.close()
    for number, file in enumerate(files):
        os.dup2(file, number)
        os.close(file)
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    return arguments


def _import_everything():
    import snakemake.cli
    import snakemake.notebook

    import boltjoint
    from boltjoint.provenance.code_dependencies import Sources

    # plugins are imported with their options
    snakemake.cli.get_argument_parser()
    for module in walk_packages(boltjoint.__path__, "boltjoint."):
        if not module.name.endswith("__main__"):
            import_module(module.name)
    # syntax trees, which are kept by the text that they are of
    sources = Sources()
    for folder in (SOURCE / "boltjoint", SOURCE.parent / "workflow/scripts"):
        for file in folder.rglob("*.py"):
            sources.used_by(file)
    # what is shared with the programs is not copied to be looked at
    gc.collect()
    gc.freeze()


def _fork_jobs(address):
    """Let Snakemake start scripts in the same way."""
    from snakemake.benchmark import BenchmarkRecord, benchmarked
    from snakemake.script import PythonScript

    def execute_script(job, file, edit=False):
        path = Path(file).resolve()
        with (
            _started(address, [path], Path.cwd(), os.environ, sys.stdout, sys.stderr) as running,
            benchmarked(running.pid, job.bench_record or BenchmarkRecord()),
        ):
            code = running.wait()
        if code:
            raise subprocess.CalledProcessError(code, [sys.executable, str(path)])

    PythonScript.execute_script = execute_script


def _run(arguments, address):
    """Run a script, or Snakemake, and end without taking apart all that is imported."""
    sys.argv = list(map(str, arguments))
    code = 0
    try:
        if isinstance(arguments[0], Path):
            sys.path[0] = str(arguments[0].parent)
            runpy.run_path(sys.argv[0], run_name="__main__")
        else:
            _fork_jobs(address)
            sys.path[0] = os.getcwd()
            sys.argv.insert(0, "snakemake")
            runpy.run_module("snakemake", run_name="__main__")
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
    except BaseException:
        sys.excepthook(*sys.exc_info())
        code = 1
    threading._shutdown()
    atexit._run_exitfuncs()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


if __name__ == "__main__":
    _run(_serve(sys.argv[1]), sys.argv[1])

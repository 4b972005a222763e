"""A real `zoned serve` for the tests of the client library, and the paths that they need."""

import contextlib
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

SOURCE = pathlib.Path(os.environ["ZONED_SOURCE_DIR"])
BUILD = pathlib.Path(os.environ["ZONED_BINARY_DIR"])
LIBRARY = BUILD / "libzoned_client.so.1"
LIBRARY_SOURCE = SOURCE / "client-sim" / "library"

os.environ["ZONED_CLIENT_LIBRARY"] = str(LIBRARY)
os.environ["LD_LIBRARY_PATH"] = str(BUILD)
sys.path.insert(0, str(LIBRARY_SOURCE / "python"))

PATIENCE_S = 60.0


class Server:
    """`port` is the TCP port, `websocket` that of WebSockets, `state` the folder with certificate and key."""

    def __init__(self, port, state, websocket=None):
        self.port = port
        self.websocket = websocket
        self.state = state


@contextlib.contextmanager
def scratch():
    folder = pathlib.Path(tempfile.mkdtemp(prefix="zoned-client-library."))
    try:
        yield folder
    finally:
        shutil.rmtree(folder)


@contextlib.contextmanager
def serve(change=None, websocket=False, world="minimal", settings=()):
    """A world that is shipped, its text changed if need be, until the end of the block."""
    with scratch() as folder:
        config = SOURCE / "config" / f"{world}.txtpb"
        if change:
            text = change(config.read_text())
            config = folder / "world.txtpb"
            config.write_text(text)
        state = folder / "state"
        command = [BUILD / "zoned", "serve", "--config", config]
        for setting in ("network.tcp_port=0", "network.udp_port=0",
                        f'session.state_folder="{state}"', *settings):
            command += ["--set", setting]
        if websocket:
            command += ["--set", "network.websocket_port=0"]
        with open(folder / "log", "w") as log:
            process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=log, text=True)
        try:
            ready = process.stdout.readline()
            if "tcp=" not in ready:
                raise RuntimeError((folder / "log").read_text())
            ports = dict(part.split("=", 1) for part in ready.split() if "=" in part)
            yield Server(int(ports["tcp"]), state, int(ports.get("websocket", 0)))
        finally:
            process.terminate()
            process.stdout.close()
            assert process.wait(PATIENCE_S) == 0, (folder / "log").read_text()

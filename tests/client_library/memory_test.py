"""The caller's allocator: every byte comes from it, all is given back, and a client without memory ends well."""

import json
import pathlib
import struct
import subprocess
import time
import unittest

from caller_test import Caller
from game_server import BUILD, LIBRARY_SOURCE, PATIENCE_S, scratch, serve
from zoned_client import State

RECORDED_S = 6.0
RICHER = """
environment { clock { name: "time_of_day" start: 8 rate_per_s: 0.02 period: 24 } }
particles {
  name: "rain"
  emitter { y_m: 30 spread_m: 40 rate_hz: 10 pitch_deg: -90 cone_deg: 3 speed_min_mps: 6 speed_max_mps: 9 lifetime_min_s: 3 seed: 1 }
}
"""


def build(folder):
    program = folder / "own_memory"
    source = pathlib.Path(__file__).parent / "own_memory.c"
    subprocess.run(["cc", "-std=c99", "-g", "-O2", "-Wall", "-Wextra", "-Werror", f"-I{LIBRARY_SOURCE}",
                    f"-L{BUILD}", "-o", program, source, "-lzoned_client", "-ldl"], check=True)
    return program


class Recorder(Caller):
    """Keeps the server's messages with their times."""

    def __init__(self, port):
        super().__init__(port, "recorder")
        self.entries = b""
        self.begun = time.monotonic()
        take = self.client.stream_frame

        def keep(frame):
            now = time.monotonic() - self.begun
            self.entries += struct.pack("<dI", now, len(frame)) + frame
            take(frame)

        self.client.stream_frame = keep

    def record(self, file):
        frame = 0
        while time.monotonic() - self.begun < RECORDED_S:
            if self.poll() == State.ONLINE and frame % 30 == 0:
                self.client.command(16, b"hello")
            frame += 1
            time.sleep(1.0 / 60.0)
        self.client.close()
        self.socket.socket.close()
        file.write_bytes(self.entries + struct.pack("<d", RECORDED_S))


class OwnMemory(unittest.TestCase):
    def run_program(self, *command):
        result = subprocess.run([str(part) for part in command], capture_output=True, text=True,
                                timeout=4 * PATIENCE_S)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        print(result.stdout.strip())
        return json.loads(result.stdout)

    def test_over_sockets(self):
        with scratch() as folder, serve(lambda text: text + RICHER) as server:
            program = build(folder)
            whole = self.run_program(program, "live", server.port)
            self.assertGreaterEqual(whole["quiet_frames"], 300)
            # The first of these bring the world; the others come while it is played.
            self.assertGreater(whole["calls"], 16)
            for n in range(1, 17):
                self.assertEqual(self.run_program(program, "live", server.port, n)["failed"], 1)

    def test_every_call_may_fail(self):
        with scratch() as folder, serve(lambda text: text + RICHER, websocket=True) as server:
            program = build(folder)
            Recorder(server.websocket).record(folder / "session")
            result = self.run_program(program, "replay", folder / "session")
        self.assertGreater(result["tried"], 150)


if __name__ == "__main__":
    unittest.main()

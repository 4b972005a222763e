"""notify_listener.py SOCKET SECONDS OUT: stands in for systemd; writes what a service sends to SOCKET into OUT, a line each."""
import os
import socket
import sys
import time

path, seconds, out = sys.argv[1], float(sys.argv[2]), sys.argv[3]
listener = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
listener.bind(path)
os.chmod(path, 0o666)
end = time.monotonic() + seconds
with open(out, "w", buffering=1) as log:
    while time.monotonic() < end:
        listener.settimeout(max(0.01, end - time.monotonic()))
        try:
            message = listener.recv(65536).decode()
        except TimeoutError:
            break
        for line in message.splitlines():
            log.write(line + "\n")

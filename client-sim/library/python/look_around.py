#!/usr/bin/env python3
"""Joins a server, walks north, and prints once a second what it sees: look_around.py [HOST [PORT]]"""

import sys
import time

from zoned_client import Client, State


def show(client):
    own = client.own()
    if own is not None:
        print("me, {} at {:.2f} {:.2f} {:.2f} m".format(own.id, *own.position))
    for entity in client.entities():
        name = client.type(entity.type).name.decode()
        print("{} {} at {:.2f} {:.2f} {:.2f} m".format(name, entity.id, *entity.position))


def main():
    host = sys.argv[1] if len(sys.argv) > 1 else "127.0.0.1"
    port = int(sys.argv[2]) if len(sys.argv) > 2 else 7777
    with Client(name="walker") as client:
        client.connect(host, port)
        client.walk(angle=0.0)
        begin = time.monotonic()
        next_s = begin + 1.0
        while time.monotonic() < begin + 5.5:
            if client.poll() == State.CLOSED:
                print(client.trouble, file=sys.stderr)
                return 1
            if time.monotonic() >= next_s and client.own() is not None:
                next_s += 1.0
                show(client)
            time.sleep(1.0 / 60.0)
    return 0


if __name__ == "__main__":
    sys.exit(main())

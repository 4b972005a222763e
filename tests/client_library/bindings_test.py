"""The bindings beside the C header: no function is left out, no struct has another size, and each C# call works."""

import ctypes
import re
import subprocess
import unittest

import game_server
import zoned_client
from game_server import LIBRARY_SOURCE, PATIENCE_S, scratch

HEADER = (LIBRARY_SOURCE / "zoned_client.h").read_text()
# The header's structs, by their names in C# and in Python.
STRUCTS = {"settings": ("Settings", "Settings"), "allocator": ("Allocator", "Allocator"),
           "sockets": ("Sockets", "Sockets"), "input": ("Input", "Input"),
           "entity": ("Entity", "Entity"), "avatar": ("Avatar", "Avatar"),
           "event": ("EventInfo", "Event"), "world": ("World", "World"),
           "type_info": ("TypeInfo", "TypeInfo"), "zone_info": ("ZoneInfo", "ZoneInfo"),
           "box": ("Box", "Box"), "field_info": ("FieldInfo", "FieldInfo"),
           "field_value": ("FieldValue", "FieldValue"), "sight": ("Sight", "Sight"),
           "aim_info": ("Aim", "Aim"), "particle": ("Particle", "Particle"),
           "stats_info": ("Stats", "Stats")}


RICHER = """
environment { clock { name: "time_of_day" start: 8 rate_per_s: 0.02 period: 24 } }
particles {
  name: "rain"
  emitter { y_m: 30 spread_m: 40 rate_hz: 100 pitch_deg: -90 cone_deg: 3 speed_min_mps: 6 speed_max_mps: 9 lifetime_min_s: 3 seed: 1 }
}
"""


def richer(text):
    """The minimal world with a mesh, a clock and rain, so that no reading is empty."""
    mesh = game_server.SOURCE / "config" / "geometry" / "bowl.obj"
    surface = f'statics {{\n  surface {{ file: "{mesh}" x_m: -25 z_m: -25 }}'
    return text.replace("statics {", surface, 1) + RICHER


def declared():
    return set(re.findall(r"^ZONED_CLIENT_API [^;(]*?\bzoned_client_(\w+)\(", HEADER, re.MULTILINE))


def sizes():
    """Bytes of each struct, as the C compiler says."""
    with scratch() as folder:
        lines = "".join(f'printf("{name} %zu\\n", sizeof(zoned_client_{name}));' for name in STRUCTS)
        (folder / "sizes.c").write_text("#include <stdio.h>\n#include <zoned_client.h>\n"
                                        f"int main(void) {{ {lines} return 0; }}\n")
        subprocess.run(["cc", f"-I{LIBRARY_SOURCE}", "-o", folder / "sizes", folder / "sizes.c"],
                       check=True)
        out = subprocess.run([folder / "sizes"], check=True, capture_output=True, text=True).stdout
    return {name: int(size) for name, size in (line.split() for line in out.splitlines())}


class Bindings(unittest.TestCase):
    def test_have_every_function(self):
        self.assertGreater(len(declared()), 30)
        csharp = (LIBRARY_SOURCE / "csharp" / "ZonedClient.cs").read_text()
        self.assertEqual(set(re.findall(r"extern \w+ zoned_client_(\w+)\(", csharp)), declared())
        # An extern alone is of no use outside: the public class must call it.
        self.assertEqual(set(re.findall(r"Native\.zoned_client_(\w+)\(", csharp)), declared())
        python = (LIBRARY_SOURCE / "python" / "zoned_client.py").read_text()
        self.assertEqual(set(re.findall(r'declare\("(\w+)"', python)), declared())

    def test_know_every_struct(self):
        named = set(re.findall(r"^typedef struct zoned_client_(\w+) \{", HEADER, re.MULTILINE))
        self.assertEqual(named, set(STRUCTS))
        for name, size in sizes().items():
            self.assertEqual(ctypes.sizeof(getattr(zoned_client, STRUCTS[name][1])), size, name)

    def test_csharp_reads_everything(self):
        arguments = [f"{STRUCTS[name][0]}={size}" for name, size in sizes().items()]
        with scratch() as folder, game_server.serve(richer, websocket=True) as server:
            program = folder / "Readings.exe"
            subprocess.run(["mcs", "-warnaserror", f"-out:{program}",
                            str(LIBRARY_SOURCE / "csharp" / "ZonedClient.cs"),
                            str(game_server.SOURCE / "tests/client_library/Readings.cs")], check=True)
            result = subprocess.run(["mono", str(program), str(server.port), str(server.websocket),
                                     *arguments], capture_output=True, text=True, timeout=PATIENCE_S)
        self.assertEqual((result.returncode, result.stdout.strip()), (0, "all readings"),
                         result.stderr)


if __name__ == "__main__":
    unittest.main()

"""The extension for Godot, compiled as a studio does and run by a host that plays Godot's side, against a real server."""

import pathlib
import re
import subprocess
import sys
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "client_library"))

from game_server import BUILD, LIBRARY_SOURCE, PATIENCE_S, scratch, serve  # noqa: E402

SOURCES = LIBRARY_SOURCE / "godot"
FLAGS = ["-std=c11", "-pedantic", "-Wall", "-Wextra", "-Werror", "-g", "-fsanitize=address,undefined",
         "-fno-sanitize-recover=all", f"-I{HERE}", f"-I{LIBRARY_SOURCE}"]
# dlsym() and get_proc_address() give pointers to functions as others.
FLAGS += ["-Wno-pedantic"]


def build(folder, sources=SOURCES):
    """Paths of the host and of the extension."""
    library, host = folder / "libzoned_godot.so", folder / "host"
    subprocess.run(["cc", *FLAGS, "-shared", "-fPIC", "-fvisibility=hidden", "-o", library,
                    sources / "zoned_godot.c", sources / "client_node.c", f"-L{BUILD}", "-lzoned_client", f"-Wl,-rpath,{BUILD}"], check=True)
    subprocess.run(["cc", *FLAGS, "-o", host, HERE / "host.c", HERE / "godot_side.c", "-lm"], check=True)
    return host, library


def play(host, library, port, *more):
    return subprocess.run([host, library, str(port), *more], capture_output=True, text=True, timeout=PATIENCE_S)


class Godot(unittest.TestCase):
    def test_a_script_joins_sees_walks_and_speaks(self):
        with scratch() as folder, serve() as server:
            result = play(*build(folder), server.port)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertRegex(result.stdout, r"sees 10 crates, 2 wanderers\nwalked 3\.")
        self.assertRegex(result.stdout, r"2\d methods, 0 blocks of memory left")
        print(result.stdout)

    def test_a_function_that_is_missing_is_named(self):
        with scratch() as folder:
            host, library = build(folder)
            names = re.findall(r"^    OFFER\((\w+)\)", (HERE / "godot_side.c").read_text(), re.MULTILINE)
            self.assertEqual(len(names), 17)
            for name in names:
                result = play(host, library, 1, "--without", name)
                self.assertEqual(result.returncode, 3, name + result.stderr)
                if name != "print_error":
                    self.assertIn(name, result.stderr)

    def test_only_the_entry_is_exported(self):
        with scratch() as folder:
            _, library = build(folder)
            lines = subprocess.run(["nm", "-D", "--defined-only", library], capture_output=True,
                                   text=True, check=True).stdout.splitlines()
        self.assertEqual([line.split()[-1] for line in lines if "zoned" in line], ["zoned_godot_init"])

    def test_the_host_finds_faults(self):
        faults = {"forget(&names[i]);": ";",
                  "give_vector(out, own.position);": "(void)out;",
                  "memcpy(out->part, entity_at(self, in)->orientation, sizeof out->part);":
                  "(void)self, (void)in, (void)out;",
                  "has != type && !(has == INT && type == FLOAT)": "0",
                  "release(m->type[taken], &in[taken]);": ";",
                  "info.is_exposed = 1;": ""}
        for right, wrong in faults.items():
            with self.subTest(right), scratch() as folder, serve() as server:
                found = 0
                for source in SOURCES.iterdir():
                    text = source.read_text()
                    found += text.count(right)
                    (folder / source.name).write_text(text.replace(right, wrong))
                self.assertEqual(found, 1)
                result = play(*build(folder, folder), server.port)
                self.assertNotEqual(result.returncode, 0, result.stdout)


if __name__ == "__main__":
    unittest.main()

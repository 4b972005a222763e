"""What the shared object shows to a game: its symbols, its size, and what it wants loaded."""

import pathlib
import re
import subprocess
import unittest

from game_server import LIBRARY, LIBRARY_SOURCE, scratch

MOST_BYTES = 300_000


def run(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


class SharedObject(unittest.TestCase):
    def test_exports_the_interface_and_nothing_else(self):
        lines = run("nm", "-D", "--defined-only", str(LIBRARY)).splitlines()
        exported = {line.split()[-1].split("@")[0] for line in lines}
        header = (LIBRARY_SOURCE / "zoned_client.h").read_text()
        declared = set(re.findall(r"^ZONED_CLIENT_API [^;(]*?\b(zoned_client_\w+)\(", header,
                                  re.MULTILINE))
        self.assertGreater(len(declared), 20)
        self.assertEqual(exported, declared)

    def test_wants_openssl_and_the_c_and_cpp_libraries_alone(self):
        wanted = re.findall(r"NEEDED.*\[(\w+)", run("readelf", "-d", str(LIBRARY)))
        self.assertIn("libssl", wanted)
        allowed = {"libssl", "libcrypto", "libstdc", "libgcc_s", "libm", "libc", "ld"}
        self.assertLessEqual(set(wanted), allowed)

    def test_takes_no_memory_but_by_an_allocator(self):
        wanted = {line.split()[-1].split("@")[0]
                  for line in run("nm", "-D", "--undefined-only", str(LIBRARY)).splitlines()}
        self.assertIn("malloc", wanted, "of the default allocator")
        taking = re.compile(r"calloc|realloc|.*alloc\w*$|strdup|_Zn[wa].*|_Zd[la].*|_ZNSs.*|_ZNSt7__cxx11.*")
        self.assertEqual({name for name in wanted if taking.fullmatch(name)} - {"malloc", "_ZSt17__throw_bad_allocv"},
                         set())

    def test_is_small(self):
        with scratch() as folder:
            stripped = folder / "stripped.so"
            run("strip", "-o", str(stripped), str(LIBRARY))
            size = stripped.stat().st_size
        print(f"libzoned_client.so: {size} bytes stripped")
        self.assertLess(size, MOST_BYTES)

    def test_runs_on_a_pc_without_avx(self):
        self.assertNotIn("%ymm", run("objdump", "-d", str(LIBRARY)))

    def test_has_a_versioned_name(self):
        soname = re.search(r"SONAME.*\[(.*)\]", run("readelf", "-d", str(LIBRARY))).group(1)
        self.assertEqual(soname, "libzoned_client.so.1")
        self.assertTrue(pathlib.Path(LIBRARY).resolve().name.startswith(soname + "."))


if __name__ == "__main__":
    unittest.main()

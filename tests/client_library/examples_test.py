"""The shipped examples in C, Python and C#, built as a user does and run against a real server."""

import re
import shutil
import subprocess
import sys
import unittest

from game_server import BUILD, LIBRARY_SOURCE, PATIENCE_S, scratch, serve

C_FLAGS = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror"]


class Examples(unittest.TestCase):
    def check(self, *command):
        """The example walks 3 m north at least, and sees ten crates and two wanderers."""
        with serve() as server:
            result = subprocess.run([*command, "127.0.0.1", str(server.port)], capture_output=True,
                                    text=True, timeout=PATIENCE_S)
        self.assertEqual(result.returncode, 0, result.stderr)
        places = re.findall(r"^me, \d+ at \S+ \S+ (\S+) m$", result.stdout, re.MULTILINE)
        self.assertGreaterEqual(len(places), 4, result.stdout)
        self.assertGreater(float(places[-1]), float(places[0]) + 3.0)
        last = result.stdout[result.stdout.rindex("me, "):]
        self.assertEqual((last.count("crate"), last.count("wanderer")), (10, 2), last)

    def test_python(self):
        self.check(sys.executable, str(LIBRARY_SOURCE / "python" / "look_around.py"))

    def test_c(self):
        with scratch() as folder:
            program = folder / "look_around"
            subprocess.run(["cc", *C_FLAGS, f"-I{LIBRARY_SOURCE}", f"-L{BUILD}", "-o", program,
                            LIBRARY_SOURCE / "c" / "look_around.c", "-lzoned_client"], check=True)
            self.check(str(program))

    @unittest.skipUnless(shutil.which("mcs"), "needs mono-mcs and mono-runtime")
    def test_csharp(self):
        with scratch() as folder:
            program = folder / "LookAround.exe"
            subprocess.run(["mcs", "-warnaserror", f"-out:{program}",
                            *map(str, (LIBRARY_SOURCE / "csharp").glob("*.cs"))], check=True)
            self.check("mono", str(program))

    def test_the_header_is_good_in_cpp(self):
        with scratch() as folder:
            source = folder / "header.cpp"
            source.write_text("#include <zoned_client.h>\n")
            subprocess.run(["c++", "-std=c++11", "-pedantic", "-Wall", "-Wextra", "-Werror", "-c",
                            f"-I{LIBRARY_SOURCE}", "-o", folder / "header.o", source], check=True)


if __name__ == "__main__":
    unittest.main()

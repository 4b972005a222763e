"""The Python module against a real server: join, see, walk, and every reading of the interface."""

import ctypes
import math
import struct
import time
import unittest

import game_server
import zoned_client
from zoned_client import Client, Error, State


def play(client, until, seconds=20.0):
    """Polls at 60 Hz until the condition holds; False when it never does."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if client.poll() == State.CLOSED:
            raise AssertionError(client.trouble)
        if until():
            return True
        time.sleep(1.0 / 60.0)
    return False


class Session(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.running = game_server.serve()
        cls.server = cls.running.__enter__()

    @classmethod
    def tearDownClass(cls):
        cls.running.__exit__(None, None, None)

    def join(self, name="walker", **settings):
        client = Client(name, **settings)
        self.addCleanup(client.close)
        client.connect("localhost", self.server.port)
        self.assertTrue(play(client, lambda: client.own() and client.stats().rtt_ms > 0))
        return client

    def test_sees_the_world_and_its_entities(self):
        client = self.join()
        world = client.world()
        names = [client.type(i).name.decode() for i in range(world.types)]
        self.assertEqual(names[:3], ["player", "crate", "wanderer"])
        self.assertTrue(client.type(0).character and not client.type(1).character)
        self.assertAlmostEqual(client.type(0).radius, 0.4, places=5)
        self.assertTrue(play(client, lambda: len(client.entities()) >= 12))
        seen = [names[entity.type] for entity in client.entities()]
        self.assertEqual((seen.count("crate"), seen.count("wanderer")), (10, 2))
        self.assertNotIn(client.own().id, [entity.id for entity in client.entities()])
        crate = client.entities()[0]
        again = client.entity(crate.id)
        self.assertEqual(list(again.position), list(crate.position))
        self.assertAlmostEqual(math.hypot(*crate.orientation), 1.0, places=4)
        self.assertIsNone(client.entity(999_999))

    def test_knows_the_static_world(self):
        client = self.join()
        zone = client.zone(0)
        self.assertEqual((list(zone.lower), list(zone.upper)), ([-50.0, -50.0], [50.0, 50.0]))
        boxes = client.boxes(0)
        self.assertEqual(len(boxes), zone.boxes)
        block = [box for box in boxes if list(box.centre) == [15.0, 1.0, 0.0]]
        self.assertEqual(list(block[0].half_extents), [2.0, 1.0, 2.0])
        self.assertEqual(len(client.triangles(0)), zone.triangles)
        self.assertEqual(client.particles(), [])

    def test_walks_where_it_wants_and_others_see_it(self):
        walker, watcher = self.join("walker"), self.join("watcher")
        begin = list(walker.own().position)
        walker.walk(angle=math.pi / 2)  # along +x
        far = lambda: walker.own().position[0] > begin[0] + 3.0
        self.assertTrue(play(walker, far))
        walker.set_input()
        self.assertAlmostEqual(walker.own().position[2], begin[2], delta=0.1)
        own = walker.own()
        self.assertAlmostEqual(own.yaw, math.pi / 2, places=3)
        self.assertAlmostEqual(own.eye[1] - own.position[1], 0.7, places=4)

        def seen():
            walker.poll()
            other = watcher.entity(walker.own().id)
            return other and math.dist(other.position, walker.own().position) < 0.5

        self.assertTrue(play(watcher, seen))

    def test_a_short_press_of_jump_counts(self):
        client = self.join()
        client.set_input(buttons=1)
        client.set_input(buttons=0)
        self.assertTrue(play(client, lambda: not client.own().grounded, 2.0))

    def test_aims_at_a_character(self):
        client = self.join()
        wanderer = lambda: [e for e in client.entities() if client.type(e.type).name == b"wanderer"]
        self.assertTrue(play(client, lambda: len(wanderer()) == 2))
        eye, at = list(client.own().eye), list(wanderer()[0].position)
        aim = client.aim(eye, [a - e for a, e in zip(at, eye)], 200.0)
        self.assertGreaterEqual(aim.sights, 1)
        self.assertIn(aim.hit, [e.id for e in wanderer()])
        self.assertAlmostEqual(aim.distance, math.dist(eye, at), delta=1.0)
        with self.assertRaises(Error):
            client.aim(eye, [0.0, 0.0, 0.0], 1.0)

    def test_time_goes_on(self):
        client = self.join()
        before, tick = client.server_time, client.world().tick
        start = time.monotonic()
        play(client, lambda: time.monotonic() > start + 0.5)
        self.assertAlmostEqual(client.server_time - before, 0.5, delta=0.1)
        self.assertAlmostEqual((client.world().tick - tick) * client.world().tick_s, 0.5, delta=0.1)
        stats = client.stats()
        self.assertGreater(stats.packets_in, 0)
        self.assertEqual((stats.malformed, stats.events_dropped), (0, 0))

    def test_interpolates_where_it_is_asked_to(self):
        client = self.join(view=zoned_client.View.INTERPOLATE)
        self.assertTrue(play(client, lambda: len(client.entities()) == 12))
        behind = client.server_time - client.world().tick * client.world().tick_s
        self.assertGreater(behind, client.world().tick_s)
        self.assertLess(behind, 0.5)

    def test_hears_events_and_sends_commands(self):
        client = self.join()
        self.assertTrue(play(client, lambda: next(client.events(), None) is not None))
        client.command(1, b"")

    def test_quits_and_joins_again(self):
        client = self.join()
        client.quit()
        self.assertEqual(client.state, State.CLOSED)
        client.connect("127.0.0.1", self.server.port)
        self.assertTrue(play(client, lambda: client.own()))

    def test_goes_to_the_certificate_that_is_pinned(self):
        client = Client("walker", trust=zoned_client.Trust.PIN, pin="ab" * 32)
        client.connect("127.0.0.1", self.server.port)
        while client.poll() != State.CLOSED:
            time.sleep(0.01)
        self.assertIn("is not the pinned one", client.trouble)

    def test_reads_older_and_newer_structs(self):
        client = self.join()
        self.assertTrue(play(client, lambda: len(client.entities()) >= 12))

        class Older(zoned_client.Sized):
            _fields_ = zoned_client.Entity._fields_[:5]

        class Newer(zoned_client.Sized):
            _fields_ = zoned_client.Entity._fields_ + [("later", ctypes.c_double)]

        function = zoned_client._library.zoned_client_entities
        known = [(e.id, list(e.position)) for e in client.entities()]
        for kind in (Older, Newer):
            array = (kind * 20)()
            array[0].size = ctypes.sizeof(kind)
            pointer = ctypes.cast(array, ctypes.POINTER(zoned_client.Entity))
            self.assertEqual(function(client._client, pointer, 20), len(known))
            self.assertEqual([(e.id, list(e.position)) for e in array[: len(known)]], known)


class WithoutServer(unittest.TestCase):
    def test_refuses_another_major_version(self):
        with self.assertRaisesRegex(Error, "version 1 .* built for version 2"):
            Client("walker", abi=2 << 16)
        Client("walker", abi=zoned_client.ABI + 7).close()

    def test_refuses_bad_arguments(self):
        with self.assertRaisesRegex(Error, "pin"):
            Client("walker", trust=zoned_client.Trust.PIN, pin="xyz")
        with self.assertRaisesRegex(Error, "trust"):
            Client("walker", trust=9)
        with Client("walker") as client:
            self.assertEqual(client.state, State.IDLE)
            for call in (lambda: client.connect("", 7777), lambda: client.connect("localhost", 0),
                         lambda: client.set_input(move_x=math.nan), lambda: client.world(),
                         lambda: client.type(0), lambda: client.command(1), client.stats):
                self.assertRaises(Error, call)
            self.assertIsNone(client.next_event())
            self.assertEqual(client.entities(), [])

    def test_says_what_was_thrown_inside(self):
        with Client("walker", trust=zoned_client.Trust.AUTHORITIES, ca_file="/no/such/file") as client:
            client.connect("127.0.0.1", 7777)
            self.assertEqual(client.poll(1.0), State.CLOSED)
            self.assertIn("cannot read the certificate authorities in /no/such/file", client.trouble)

    def test_goes_on_with_a_clock_that_is_none(self):
        with Client("walker") as client:
            client.connect("127.0.0.1", 9)
            for now_s in (math.nan, math.inf, -math.inf, 1e300, -5.0, 0.0):
                self.assertIn(client.poll(now_s), list(State))

    def test_survives_null_everywhere(self):
        library = zoned_client._library
        names = ["abi_version", "create", "destroy", "connect", "quit", "poll", "get_state",
                 "trouble", "set_input", "command", "next_event", "entities", "get_entity", "own",
                 "get_world", "type", "fields", "field", "field_at", "field_named", "deform", "zone", "aim",
                 "stats", "shared_value", "server_time", "boxes", "triangles", "particles"]
        for name in names:
            function = getattr(library, "zoned_client_" + name)
            zeros = [None if issubclass(kind, (ctypes._Pointer, ctypes.c_char_p, ctypes.c_void_p))
                     else 0 for kind in function.argtypes or []]
            function(*zeros)


def arena(_):
    """The world whose rules in Lua set declared fields."""
    folder = game_server.SOURCE / "config"
    text = (folder / "arena.txtpb").read_text()
    return text.replace('"scripts/arena.lua"', f'"{folder}/scripts/arena.lua"')


class Fields(unittest.TestCase):
    def test_of_a_game_are_read_by_name_and_index(self):
        with game_server.serve(arena) as server, Client("ann") as ann, Client("bob") as bob:
            for client in (ann, bob):
                client.connect("localhost", server.port)
            self.assertTrue(play(ann, lambda: bob.poll() and ann.own() and bob.own()))
            names = [ann.type(i).name for i in range(ann.world().types)]
            fields = {field.name: field for field in ann.fields(names.index(b"player"))}
            self.assertEqual(list(fields), [b"health", b"kills"])
            self.assertEqual((fields[b"health"].minimum, fields[b"health"].maximum), (0.0, 100.0))
            self.assertEqual(ann.fields(names.index(b"ball")), [])
            target = bob.own().id
            self.assertTrue(play(ann, lambda: bob.poll() and ann.entity(target)))
            self.assertEqual((ann.field(target, "health"), ann.field(target, 1)), (100.0, 0.0))
            self.assertIsNone(ann.field(target, "stamina"))
            self.assertIsNone(ann.field(target, 2))
            self.assertIsNone(ann.field(999_999, "health"))

            shots = []

            def hit():
                bob.poll()
                if shots and time.monotonic() < shots[-1] + 0.5:
                    return bob.field(target, "health") < 100.0
                shots.append(time.monotonic())
                aim = [b - a for a, b in zip(ann.own().eye, bob.own().position)]
                ann.command(2, b"".join(struct.pack("<Bf", tag, part / math.hypot(*aim))
                                        for tag, part in zip((0x15, 0x1D, 0x25), aim)))
                return False

            self.assertTrue(play(ann, hit))
            self.assertTrue(play(ann, lambda: bob.poll() and ann.field(target, "health") < 100.0))

    def test_of_a_soft_body_deform_a_mesh(self):
        """The curtain hangs by two corners, which are where the world's file puts them."""
        with game_server.serve(world="cloth") as server, Client("ann") as ann:
            ann.connect("localhost", server.port)
            self.assertTrue(play(ann, lambda: ann.own() and ann.entities()))
            names = [ann.type(i).name for i in range(ann.world().types)]
            kinds = {one.type: one.id for one in ann.entities()}
            self.assertTrue(play(ann, lambda: kinds.update({one.type: one.id for one in ann.entities()}) or
                                 {names.index(b"curtain"), names.index(b"crate")} <= kinds.keys()))
            curtain = kinds[names.index(b"curtain")]
            self.assertIsNone(ann.deform(kinds[names.index(b"crate")], [(0, 0, 0)]))
            self.assertIsNone(ann.deform(999_999, [(0, 0, 0)]))
            corners = [(-2.0, 1.2, 0.0), (2.0, 1.2, 0.0)]

            def hangs_through():
                left, middle = ann.deform(curtain, [corners[0], (0.0, 1.2, 0.0)])
                return middle[1] < left[1] - 0.02

            self.assertTrue(play(ann, hangs_through))
            deformed = ann.deform(curtain, corners)
            pose = ann.entity(curtain)
            for corner, place in zip(corners, deformed):
                at = [p + t for p, t in zip(pose.position, turned(pose.orientation, place))]
                truth = (-8.0 + corner[0], 1.6 + corner[1], -6.0)
                # The bounds of its shape, of its place and of its turn.
                self.assertLess(math.dist(at, truth), 0.07 + 0.05 + 0.1 * math.hypot(*corner))


def turned(q, v):
    """A vector turned by a quaternion of x, y, z, w."""
    x, y, z, w = q
    across = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])]
    return [v[0] + w * across[0] + y * across[2] - z * across[1],
            v[1] + w * across[1] + z * across[0] - x * across[2],
            v[2] + w * across[2] + x * across[1] - y * across[0]]


if __name__ == "__main__":
    unittest.main()

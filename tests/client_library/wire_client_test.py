"""A client in Python that was written from proto/WIRE.md plays on a real server, beside bots of client-sim."""

import contextlib
import copy
import math
import subprocess
import time
import unittest
from unittest import mock

import game_server
import proto_messages
import wire_client
import wire_motion
import wire_player
from wire_client import WireClient
from wire_judge import Judge, clean_samples, percentiles
from wire_session import PROTO, Network

SANDBOX = proto_messages.Schema(PROTO / "sandbox.proto")
CORNERS = ((-3.0, -3.0), (6.0, -3.0), (6.0, 6.0), (-3.0, 6.0))
PAUSE = range(90, 132)  # of each 150 ticks: the server repeats the last command, then the avatar stands
JUMP_EVERY, SPRINT_LEG = 40, 2
PAUSED_SAMPLES, PAUSED_S = 6, 20  # own states of pauses, in which some faults show alone, and how long they may take
FROZEN_AUDITS = 3  # all is published as it stands when the world stops; audits come every 15 ticks
# Half an ulp of positions within 64 m of a zone's origin is 2^-19 m. A border is crossed within 16 ticks of the newest
# state that was told: two changes of coordinates and 16 sums of either side, on three axes.
CROSSING_M = (2 + 2 * 16) * 2 ** -19 * math.sqrt(3)


class Course:
    """Steers to one corner after the other, with jumps, a leg at a run, and pauses in which no commands are made."""

    def __init__(self, client):
        self.client, self.leg = client, 0

    def __call__(self, tick):
        if tick % 150 in PAUSE:
            return None
        prediction = self.client.player.prediction
        place = prediction.world_position(prediction.state().position)
        x, z = (corner - at for corner, at in zip(CORNERS[self.leg % 4], place[::2]))
        if math.hypot(x, z) < 0.7:
            self.leg += 1
        angle = math.atan2(x, z)
        buttons = wire_motion.JUMP * (tick % JUMP_EVERY == 0) | wire_motion.SPRINT * (self.leg % 4 == SPRINT_LEG)
        yaw = round(angle / math.tau * 65536) % 65536
        return round(127 * math.sin(angle)), round(127 * math.cos(angle)), yaw, 0, buttons


@contextlib.contextmanager
def bots(server, seconds):
    """Four bots that walk and talk."""
    command = [game_server.BUILD / "client-sim", "--connect", f"127.0.0.1:{server.port}", "--bots", "4", "--seconds",
               str(seconds), "--behaviour", "wander:3,chat:1", "--no-freeze", "--quiet"]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield
    finally:
        process.terminate()
        process.wait(game_server.PATIENCE_S)


class Play:
    """Some seconds of a client in a world, and what they must have been like."""

    def __init__(self, test, server, loss=0.0, delay_s=0.0):
        networks = [Network(loss, delay_s, 0.25 * delay_s, seed) for seed in (1, 2)]
        self.test, self.audits, self.displayed, self.ahead_ticks = test, [], [], []
        self.client = WireClient("127.0.0.1", server.port, name="Ann", up=networks[0], down=networks[1])
        self.client.on_audit = self.take_audit
        self.course = self.client.drive = Course(self.client)

    def take_audit(self, audit):
        """Notes the truth, and how far from it the view is when it comes."""
        self.audits.append(audit)
        if self.client.clock.known() and not audit.frozen:
            self.ahead_ticks.append(self.client.clock.server_tick(time.monotonic()) - audit.tick)
        view = self.client.player.view
        for entity in audit.entities:
            publication = view.at(entity.entity)
            if publication and entity.must_know:
                self.displayed.append(math.dist(view.position(publication, audit.tick), entity.position))

    def says(self, text):
        """A chat line, which comes back once."""
        chat = SANDBOX.encode("Chat", {"topic": "world", "text": text})
        self.client.session.command(SANDBOX.enums["COMMAND_CHAT"], chat)
        lines = lambda: [SANDBOX.decode("ChatLine", event.payload) for event in self.client.session.events
                         if event.kind == SANDBOX.enums["EVENT_CHAT"]]
        heard = lambda: [(line.name, line.client) for line in lines() if line.text == text.encode()]
        self.test.assertTrue(self.client.run(5, heard), "a chat line that nobody heard")
        self.test.assertEqual(heard(), [(b"Ann", self.client.session.welcome.client_id)])

    def go_on(self):
        """Plays until there are own states of pauses: bots in the way and lost packets cost some."""
        paused = lambda: sum(sample.missing for sample in clean_samples(self.client.player)[0])
        end = time.monotonic() + PAUSED_S
        while paused() < PAUSED_SAMPLES and time.monotonic() < end:
            self.client.run(1)

    def freeze(self):
        """Stops the world, until the truth of the frozen world has come twice."""
        self.client.session.send("freeze", {"on": True})
        frozen = lambda: sum(audit.frozen for audit in self.audits) >= FROZEN_AUDITS
        self.test.assertTrue(self.client.run(8, frozen), "the world was not frozen")
        self.audits = [audit for audit in self.audits if not audit.frozen] + self.audits[-1:]

    def judged(self, player=None):
        """The audits but for the first half second, in which entities still come."""
        judge = Judge(player or self.client.player)
        for audit in self.audits:
            if audit.tick > self.audits[0].tick + 30:
                judge.judge(audit)
        return judge

    def check_clock(self):
        """An audit leaves in the stream, which nothing delays, right after the step of its tick."""
        least = min(self.ahead_ticks[2:])
        print(f"  clock: {least:.3f} ticks ahead of audits at least")
        self.test.assertGreater(least, -0.3)
        self.test.assertLess(least, 0.7)

    def check_view(self):
        """What it showed of others."""
        judge = self.judged()
        self.test.assertEqual(judge.findings, [])
        self.test.assertGreater(len(judge.errors), 40)
        self.test.assertGreater(judge.exact, 3)
        print(f"  others: {len(judge.errors)} positions off by m: {percentiles(judge.errors)}; of what is allowed "
              f"{max(judge.ratios):.2f}; as displayed {percentiles(self.displayed)}; {judge.exact} exact when frozen; "
              f"{judge.passed_over} passed over; {judge.words} declared fields")
        return judge

    def check_prediction(self):
        """Where it predicted itself: to the bit, where nothing stood in the way."""
        clean, touched = clean_samples(self.client.player)
        print(f"  own: {len(clean)} states off by m: {percentiles(sample.error for sample in clean)}; "
              f"{touched} near others or late; {sum(sample.missing for sample in clean)} without a command; "
              f"{self.course.leg} corners")
        self.test.assertGreater(len(clean), 20)
        self.test.assertGreater(self.course.leg, 2)
        for sample in clean:
            self.test.assertLessEqual(sample.error, CROSSING_M if sample.crossed else 0.0, vars(sample))
        self.test.assertGreaterEqual(sum(sample.missing for sample in clean), PAUSED_SAMPLES)
        self.test.assertGreater(sum(not sample.grounded for sample in clean), 1)

    def replayed(self, world=None):
        """A player that goes through the same packets again."""
        return wire_client.replay(world or self.client.session.world, self.client.journal)

    def check_faults(self):
        """Each fault of a client is found; without one the journal says the same again."""
        self.test.assertEqual(self.judged(self.replayed()).findings, [])
        for name, fault in self.view_faults():
            with fault:
                self.test.assertGreater(len(self.judged(self.replayed(self.wrong(name))).findings), 0, name)
        for name, fault in self.own_faults():
            with fault:
                clean, _ = clean_samples(self.replayed(self.wrong(name)))
                self.test.assertTrue(any(sample.error > CROSSING_M for sample in clean), name)

    def wrong(self, name):
        """The world of Welcome, wrong in one number where the fault is one of these."""
        world = copy.deepcopy(self.client.session.world)
        if name == "quantum":
            world.quantization.position_step_m *= 1.01
        elif name == "gravity":
            for kind in world.types:
                if kind.character:
                    kind.limits.gravity *= 1.001
        elif name == "tick":
            world.tick_rate_hz *= 1.1
        return world

    @staticmethod
    def view_faults():
        """Of what is seen."""
        position = wire_player.View.position
        swapped = lambda view, *of: position(view, *of)[::-1]
        stale = lambda publication, level, gravity, t: [part * level.position for part in publication.position]
        nothing = contextlib.nullcontext()
        return (("quantum", nothing), ("axis", mock.patch.object(wire_player.View, "position", swapped)),
                ("dead reckoning", mock.patch.object(wire_motion, "predict_position", stale)))

    @staticmethod
    def own_faults():
        """Of what is predicted."""
        wanted, nothing = wire_motion.wanted_velocity, contextlib.nullcontext()
        swapped = lambda command, limits: wanted(command, limits)[::-1]
        stands = lambda last, tick, dt: wire_motion.Command(tick)
        walks_on = lambda last, tick, dt: wire_motion.Command(tick, last.move_x, last.move_z, last.yaw)
        return (("axis", mock.patch.object(wire_motion, "wanted_velocity", swapped)),
                ("skipped repeat", mock.patch.object(wire_motion, "missing_command", stands)),
                ("endless repeat", mock.patch.object(wire_motion, "missing_command", walks_on)),
                ("gravity", nothing), ("tick", nothing))


class Worlds(unittest.TestCase):
    """A world for each codec."""

    def test_shared_records(self):
        with game_server.serve(settings=["replication.codec=SHARED"]) as server, bots(server, 60):
            play = Play(self, server)
            play.client.run(6)
            play.says("hello")
            play.go_on()
            play.freeze()
            print("\nminimal, shared records")
            self.assertEqual((play.client.player.counts["coded"], play.client.player.troubles), (0, []))
            play.check_view()
            play.check_prediction()
            play.check_clock()
            play.check_faults()
            play.client.session.quit()

    def test_coded_records_on_a_bad_network(self):
        with game_server.serve(world="arena", settings=["replication.codec=PER_CLIENT"]) as server, bots(server, 60):
            play = Play(self, server, 0.05, 0.04)
            play.client.run(4)
            play.client.session.send("view_reset", {"reason": "a test"})
            play.client.run(4)
            play.says("hello")
            play.go_on()
            play.freeze()
            print("\narena, coded records, 40 ms and 5 % loss each way")
            counts = play.client.player.counts
            self.assertGreater(counts["coded"], 50)
            self.assertEqual(play.client.player.troubles, [])
            judge = play.check_view()
            self.assertGreater(judge.words, 5)
            play.check_prediction()
            play.check_clock()
            play.check_faults()
            play.client.session.quit()


if __name__ == "__main__":
    unittest.main()

// Clients are notified of entities that wait under pressure. The bounds that a client last
// received, or receives with its next packet, hold in every tick for all that it knows.
#include "tests/unit/replication/session.h"
#include "shared/motion/dead_reckoning.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

namespace zoned::replication {
namespace {

/// On a path without delay and loss, so that only the budget makes updates late.
class Judge {
  public:
    struct Verdict {
        std::uint64_t compared = 0;
        std::uint64_t widened = 0;    ///< of these: under bounds notified to be wider
        std::uint64_t unbounded = 0;  ///< notified that there is no bound
        std::uint64_t broken = 0;
        double worst = 0.0;  ///< error as a share of the allowed error
        std::uint64_t waited_after_switch = 0;
    };

    explicit Judge(std::size_t clients) : clients_(clients) {}

    /// After each tick of the session.
    void look(const Session& s) {
        for (std::size_t c = 0; c < clients_.size(); ++c) {
            Client& client = clients_[c];
            std::optional<wire::Widened> notified;
            for (const mailbox::StatePacket& p : s.packets) {
                if (p.client.value == c + 1) {
                    notified = wire::read_down_head(p.body)->head.widened;
                }
            }
            for (const world::Visible& v : s.visibility[c].visible) {
                const auto known = s.remotes[c].model.known.find(v.entity);
                if (known != s.remotes[c].model.known.end()) {
                    client.open.push_back(error_of(s, v, known->second, s.remotes[c].model));
                    verdict.waited_after_switch += known->second.lod != v.lod ? 1 : 0;
                }
            }
            if (notified) {
                const std::uint8_t step = std::max(client.notified.step, notified->step);
                for (const Error& error : client.open) {
                    judge(error, step, s.settings);
                }
                client.open.clear();
                client.notified = *notified;
            }
        }
    }

    Verdict verdict;

  private:
    struct Error {
        double in_bounds = 0.0;  ///< of the level at which the entity is heard now
        std::uint8_t lod = 0;
    };

    struct Client {
        wire::Widened notified;   ///< by the packet before
        std::vector<Error> open;  ///< since then
    };

    static Error error_of(const Session& s,
                          const world::Visible& v,
                          const ModelClient::Known& known,
                          const ModelClient& model) {
        const world::Row row = s.world.entities.find(v.entity);
        const motion::KinematicState shown = model.predict(known, s.world.now);
        const motion::KinematicState truth = s.world.entities.kinematic(row);
        const wire::Quantization q = wire::at_lod(s.settings.quantization, known.lod);
        const LodBound& bound = s.settings.lods[v.lod];
        const bool upright = s.types[known.type].upright();
        // Single-precision errors of places 40 m off, and of angles, are added to the quanta.
        const float off_m =
            (shown.position - truth.position).norm() - q.position_quantum_m() - 1e-4F;
        const float off_rad = motion::angle_between(shown.orientation, truth.orientation) -
                              q.orientation_quantum_rad(upright) - 1e-3F;
        return {std::max(off_m / bound.position_m, off_rad / bound.orientation_rad), v.lod};
    }

    void judge(const Error& error, std::uint8_t step, const ReplicationSettings& settings) {
        ++verdict.compared;
        verdict.widened += step > 0 ? 1 : 0;
        if (step == wire::kNoBound) {
            ++verdict.unbounded;
            return;
        }
        const double of_allowed =
            error.in_bounds / wire::widening(step, error.lod, settings.lods.size());
        verdict.worst = std::max(verdict.worst, of_allowed);
        verdict.broken += of_allowed > 1.0 ? 1 : 0;
    }

    std::vector<Client> clients_;
};

void print(const Judge::Verdict& v) {
    std::printf(
        "%llu compared, %llu widened, %llu unbounded, %llu while a level was changed, "
        "%llu broken, worst %.2f of what was allowed\n",
        static_cast<unsigned long long>(v.compared),
        static_cast<unsigned long long>(v.widened),
        static_cast<unsigned long long>(v.unbounded),
        static_cast<unsigned long long>(v.waited_after_switch),
        static_cast<unsigned long long>(v.broken),
        v.worst);
}

constexpr std::uint32_t kClients = 4;

ReplicationSettings narrow_settings(std::uint32_t bytes_per_s) {
    ReplicationSettings settings = test_settings();
    settings.budget_bytes_per_s = bytes_per_s;
    return settings;
}

TEST(NotifiedBounds, WhatWaitsUnderPressureHoldsTheWiderBoundsThatAreNotified) {
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
        Session s(seed, narrow_settings(2500), {}, 80, 20, kClients, 40.0F);
        Judge judge(kClients);
        for (int tick = 0; tick < 900; ++tick) {
            s.step();
            judge.look(s);
        }
        print(judge.verdict);
        EXPECT_GT(judge.verdict.compared, 100'000U);
        EXPECT_GT(judge.verdict.widened, judge.verdict.compared / 10);
        EXPECT_LT(judge.verdict.unbounded, judge.verdict.compared / 2);
        EXPECT_GT(judge.verdict.waited_after_switch, 100U);  // else the test does not cover it
        EXPECT_EQ(judge.verdict.broken, 0U);
    }
}

/// A client that comes from another zone knows entities from there, and the new zone does not know
/// how. Much of the time there is room for all, and only new notifications have to wait.
TEST(NotifiedBounds, AlsoToWhoComesFromAnotherZone) {
    for (const std::uint32_t bytes_per_s : {2500U, 6000U}) {
        Session s(4, narrow_settings(bytes_per_s), {}, 80, 20, kClients, 40.0F);
        Judge judge(kClients);
        for (int tick = 0; tick < 1800; ++tick) {
            if (tick % 60 == 59) {
                const ClientId client(1 + static_cast<std::uint32_t>(tick / 60) % kClients);
                s.replicator.add_client(s.replicator.remove_client(client));
            }
            s.step();
            judge.look(s);
        }
        print(judge.verdict);
        EXPECT_GT(judge.verdict.widened, judge.verdict.compared / 20);
        EXPECT_LT(judge.verdict.unbounded, judge.verdict.compared / 2);
        EXPECT_EQ(judge.verdict.broken, 0U);
    }
}

/// Ticks for which clients lacked an entity in view, while they were not notified that it waits.
std::uint64_t silent_waits(std::uint32_t bytes_per_s, std::uint64_t& all_waits) {
    // A copy and the word of its loss take at most 15 ticks: half a round trip, the longest
    // silence, half a round trip. Three copies in a row are lost once in 64 times.
    constexpr Tick kTicksToTell = 45;
    NetSettings net;
    net.loss = 0.25F;
    net.delay_ticks = 3;
    Session s(5, narrow_settings(bytes_per_s), net, 120, 20, kClients, 60.0F);
    std::array<std::map<std::uint32_t, Tick>, kClients> since;  // by entity that is lacked now
    std::vector<mailbox::AuditUpdate> updates;
    std::uint64_t silent = 0;
    for (int tick = 0; tick < 1200; ++tick) {
        s.step();
        for (std::uint32_t c = 0; c < kClients; ++c) {
            std::map<std::uint32_t, Tick> told_at;
            s.replicator.unacknowledged(ClientId(c + 1), updates);
            for (const mailbox::AuditUpdate& update : updates) {
                told_at[update.entity.value] = update.postponed_tick;
            }
            std::map<std::uint32_t, Tick> lacked;
            for (const world::Visible& v : s.visibility[c].visible) {
                if (s.remotes[c].model.known.contains(v.entity)) {
                    continue;
                }
                const auto before = since[c].find(v.entity.value);
                const Tick from = before != since[c].end() ? before->second : s.world.now;
                lacked[v.entity.value] = from;
                all_waits += s.world.now - from > kTicksToTell ? 1 : 0;
                silent += s.world.now - std::max(from, told_at[v.entity.value]) > kTicksToTell;
            }
            since[c] = std::move(lacked);
        }
    }
    return silent;
}

/// Also where what was sent was lost, and waits to be sent again.
TEST(NotifiedBounds, WhoLacksAnEntityIsNotifiedThatItWaits) {
    std::uint64_t waits = 0;
    const std::uint64_t silent = silent_waits(1000, waits);
    EXPECT_LT(silent, waits / 64);
    EXPECT_GT(waits, 1000U);
}

/// The checker finds a server that keeps silent about it.
TEST(NotifiedBounds, SilenceIsFound) {
    Session s(1, narrow_settings(2500), {}, 80, 20, kClients, 40.0F);
    Judge judge(kClients);
    for (int tick = 0; tick < 300; ++tick) {
        s.step();
        for (mailbox::StatePacket& packet : s.packets) {
            if (wire::read_down_head(packet.body)->head.has_widened) {
                wire::rewrite_widened(wire::Widened{}, packet.body);
            }
        }
        judge.look(s);
    }
    EXPECT_GT(judge.verdict.broken, 0U);
}

}  // namespace
}  // namespace zoned::replication

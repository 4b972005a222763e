// Checks what clients really receive against their radii, concealment and topics, by the raw state
// of the world.
#include "tests/harness/capture.h"

#include "server/app/world/world.h"
#include "server/interest/interest_rule.h"
#include "server/zone/context/zone_context.h"
#include "server/zone/viewers/visibility_filter.h"
#include "tests/harness/game_test.h"

#include <map>
#include <set>

namespace zoned::harness {
namespace {

/// The entities that each client may know in each tick, from positions and radii alone. It reads no
/// result of matching, concealment or topics.
class Truth {
  public:
    void observe(VirtualServer& server) {
        const Tick now = server.world().now();
        if (now == newest_) {
            return;
        }
        newest_ = now;
        for (const auto& zone : server.world().zones()) {
            const zone::ZoneState& state = zone->state();
            for (const zone::ZoneClient& client : state.clients) {
                observe_client(zone->state(), client);
            }
            for (const zone::PendingEvent& pending : state.out.events) {
                if (pending.audience == zone::Audience::kViewers) {
                    source_of_[pending.event.event.value] = pending.source;
                }
            }
        }
    }

    /// By radii with hysteresis in that tick. A concealed entity must also have been seen recently:
    /// within the age limit of answers and the time that known entities stay known.
    [[nodiscard]] bool may_know(ClientId client, EntityId entity, Tick tick) const {
        const auto at = ticks_.find({client, tick});
        if (at == ticks_.end() || at->second.within.count(entity) == 0) {
            return false;
        }
        if (at->second.filterable.count(entity) == 0) {
            return true;
        }
        for (Tick t = tick; t >= tick - past_; --t) {
            const auto then = ticks_.find({client, t});
            if (then != ticks_.end() && then->second.seen.count(entity) != 0) {
                return true;
            }
        }
        return false;
    }

    [[nodiscard]] bool ever_knew(ClientId client, EntityId entity) const {
        return ever_.count({client, entity}) != 0;
    }

    [[nodiscard]] EntityId avatar(ClientId client) const {
        const auto at = avatar_.find(client);
        return at == avatar_.end() ? EntityId() : at->second;
    }

    /// None: not announced by an entity.
    [[nodiscard]] EntityId source(std::uint64_t event) const {
        const auto at = source_of_.find(event);
        return at == source_of_.end() ? EntityId() : at->second;
    }

    [[nodiscard]] bool was_in_zone(ClientId client, ZoneId zone, Tick tick) const {
        for (Tick t = tick - 1; t <= tick; ++t) {
            const auto at = ticks_.find({client, t});
            if (at != ticks_.end() && at->second.zone == zone) {
                return true;
            }
        }
        return false;
    }

    std::uint64_t beyond = 0;    ///< pairs and ticks out of the radii
    std::uint64_t filtered = 0;  ///< within them, and not to be seen

  private:
    struct Moment {
        ZoneId zone;
        std::set<EntityId> within;
        std::set<EntityId> filterable;  // of these
        std::set<EntityId> seen;        // of these
    };

    void observe_client(zone::ZoneState& state, const zone::ZoneClient& client) {
        Moment& moment = ticks_[{client.client, newest_}];
        moment.zone = state.settings.id;
        avatar_[client.client] = client.avatar;
        const zone::VisibilityFilterSettings& filter = state.settings.visibility_filter;
        past_ = static_cast<Tick>(filter.stale_ticks + filter.grace_ticks);
        const zone::ZoneContext context(state);
        const world::Row avatar = state.entities.find(client.avatar);
        std::vector<world::Row> inner, outer;
        interest::brute_force(state.entities,
                              *state.settings.types,
                              {client.client, client.avatar},
                              state.settings.interest,
                              inner,
                              outer);
        beyond += state.entities.size() - 1 - outer.size();
        for (const world::Row row : outer) {
            const EntityId entity = state.entities.id[row];
            moment.within.insert(entity);
            ever_.insert({client.client, entity});
            const world::EntityType& type = (*state.settings.types)[state.entities.type[row]];
            if (type.visibility_filter != world::VisibilityFilter::kNothing) {
                moment.filterable.insert(entity);
                if (zone::may_know(state, context, avatar, row)) {
                    moment.seen.insert(entity);
                } else {
                    ++filtered;
                }
            }
        }
    }

    std::map<std::pair<ClientId, Tick>, Moment> ticks_;
    std::set<std::pair<ClientId, EntityId>> ever_;
    std::map<ClientId, EntityId> avatar_;
    std::map<std::uint64_t, EntityId> source_of_;
    Tick newest_ = -1;
    Tick past_ = 0;
};

/// Violations of the rules in the received data, and the number of comparisons.
struct Judgement {
    std::uint64_t records = 0;
    std::uint64_t wrong_records = 0;
    std::uint64_t topic_events = 0;
    std::uint64_t wrong_topics = 0;
    std::uint64_t announced_events = 0;
    std::uint64_t wrong_announced = 0;
    std::uint64_t undecoded = 0;
    std::uint64_t coded_packets = 0;
    std::uint64_t overtaken = 0;  ///< of these, too late to be read by any client

    [[nodiscard]] bool clean() const {
        return wrong_records == 0 && wrong_topics == 0 && wrong_announced == 0 && undecoded == 0;
    }
};

/// Under each codec of records.
class Captured : public GameTest, public ::testing::WithParamInterface<const char*> {
  protected:
    Captured() {
        bots.bots = 10;
        bots.seconds = 6.0;
        bots.mix = *bot::parse_mix("wander:4,chat:3,fight:2,border:1");
        server.network.loss = 0.05;
        server.network.delay_s = 0.04;
        server.network.jitter_s = 0.01;
        server.network.duplicate = 0.02;
        server.network.reorder = 0.05;
        // Radii that end within the world.
        server.sets = {"type[0].nimbus_m.normal=20",
                       "type[0].nimbus_m.running=14",
                       std::string("replication.codec=") + GetParam()};
    }

    /// A long wall with crates on both sides of it; viewers may know the crates that they can see.
    void put_up_a_wall() {
        for (const char* set : {"statics.box[0].x_m=-6",
                                "statics.box[0].y_m=3",
                                "statics.box[0].size.x_m=1",
                                "statics.box[0].size.y_m=6",
                                "statics.box[0].size.z_m=60",
                                "scatter[0].count=60",
                                "type[0].nimbus_m.normal=30",
                                "type[1].visibility_filter=LINE_OF_SIGHT"}) {
            server.sets.emplace_back(set);
        }
    }

    Judgement run_captured() {
        world = std::make_unique<VirtualServer>(server);
        const auto make = [this](std::size_t) {
            captures_.push_back(std::make_shared<Capture>());
            captures_.back()->quantization = world->settings().replication.quantization;
            captures_.back()->tick_s = world->settings().replication.tick_s;
            for (const world::EntityType& type : world->settings().types) {
                captures_.back()->upright.push_back(type.upright());
            }
            return capture_transport(world->connect(), captures_.back());
        };
        swarm = std::make_unique<app::Swarm>(bots, make);
        while (!swarm->done() && world->now_s() < bots.seconds + 600.0) {
            world->step();
            truth_.observe(*world);
            for (const auto& capture : captures_) {
                capture->now_s = world->client_time_s();
            }
            swarm->advance(world->client_time_s());
        }
        EXPECT_TRUE(swarm->done());
        Judgement all;
        for (std::size_t i = 0; i < captures_.size(); ++i) {
            judge(*captures_[i], swarm->bots()[i]->settings().login.team, all);
        }
        return all;
    }

    void judge(const Capture& c, const std::string& team, Judgement& all) const {
        all.undecoded += c.undecoded;
        all.overtaken += c.overtaken;
        all.coded_packets += c.coded_packets;
        for (const CapturedRecord& record : c.records) {
            ++all.records;
            const bool allowed = record.remove
                                     ? truth_.ever_knew(c.client, record.entity)
                                     : truth_.may_know(c.client, record.entity, record.tick);
            all.wrong_records += allowed ? 0U : 1U;
        }
        for (const CapturedEvent& event : c.events) {
            if (!event.topic.empty()) {
                ++all.topic_events;
                all.wrong_topics += subscribed(c.client, team, event) ? 0U : 1U;
                continue;
            }
            const EntityId source = truth_.source(event.event_id);
            if (source) {
                ++all.announced_events;
                const bool allowed = source == truth_.avatar(c.client) ||
                                     truth_.may_know(c.client, source, event.tick);
                all.wrong_announced += allowed ? 0U : 1U;
            }
        }
    }

    /// All players are in the topic `world`, and in those of the own team and of the avatar's zone.
    [[nodiscard]] bool subscribed(ClientId client,
                                  const std::string& team,
                                  const CapturedEvent& event) const {
        if (event.topic == "world") {
            return true;
        }
        if (event.topic.rfind("team/", 0) == 0) {
            return event.topic.substr(5) == team;
        }
        if (event.topic.rfind("zone/", 0) == 0) {
            const ZoneId zone(static_cast<std::uint16_t>(std::stoul(event.topic.substr(5))));
            return truth_.was_in_zone(client, zone, event.tick);
        }
        return false;
    }

    Truth truth_;
    std::vector<std::shared_ptr<Capture>> captures_;
};

void expect_clean(const Judgement& j) {
    EXPECT_EQ(j.undecoded, 0U);
    // Of the reordered packets, which are a few in a hundred.
    EXPECT_LE(50 * j.overtaken, j.coded_packets);
    EXPECT_EQ(j.wrong_records, 0U) << "of " << j.records;
    EXPECT_EQ(j.wrong_topics, 0U) << "of " << j.topic_events;
    EXPECT_EQ(j.wrong_announced, 0U) << "of " << j.announced_events;
    EXPECT_GT(j.records, 1000U);
    EXPECT_GT(j.topic_events, 10U);
}

TEST_P(Captured, ClientsReceiveNothingThatRadiiAndTopicsDoNotAllow) {
    const Judgement j = run_captured();
    expect_clean(j);
    EXPECT_EQ(j.coded_packets > 1000U, std::string(GetParam()) == "PER_CLIENT");
    EXPECT_GT(truth_.beyond, 1000U);
}

TEST_P(Captured, ClientsReceiveNothingBeyondTheirRadiiAcrossBordersOfZones) {
    server.sets.emplace_back("zones.zone_grid.columns=2");
    expect_clean(run_captured());
    EXPECT_GT(truth_.beyond, 1000U);
}

TEST_P(Captured, ClientsReceiveNothingThatIsOutOfSight) {
    for (const char* type : {"0", "1", "2"}) {
        server.sets.push_back(std::string("type[") + type + "].visibility_filter=LINE_OF_SIGHT");
    }
    expect_clean(run_captured());
    EXPECT_GT(truth_.filtered, 1000U);
}

TEST_P(Captured, TheCheckerFindsALeakedEntity) {
    server.sets.emplace_back("testing.leak_entity.probability=1");
    EXPECT_GT(run_captured().wrong_records, 0U);
}

TEST_P(Captured, TheCheckerFindsALeakedTopic) {
    server.sets.emplace_back("testing.leak_topic.probability=1");
    EXPECT_GT(run_captured().wrong_topics, 0U);
}

TEST_P(Captured, TheCheckerFindsWhatIsFilteredAndSentAllTheSame) {
    put_up_a_wall();
    server.sets.emplace_back("testing.leak_filtered.probability=1");
    EXPECT_GT(run_captured().wrong_records, 0U);
}

TEST_P(Captured, TheVerdictOfTheBotsFindsWhatIsFilteredAndSentAllTheSame) {
    put_up_a_wall();
    expect_clean(run_captured());
    EXPECT_TRUE(swarm->report().consistent) << reasons(swarm->report());
    server.sets.emplace_back("testing.leak_filtered.probability=1");
    swarm.reset();
    captures_.clear();
    truth_ = Truth();
    run_captured();
    EXPECT_FALSE(swarm->report().consistent);
    EXPECT_GT(swarm->report().audit.extra, 0U);
}

INSTANTIATE_TEST_SUITE_P(Codecs,
                         Captured,
                         ::testing::Values("SHARED", "PER_CLIENT"),
                         [](const auto& tested) { return std::string(tested.param); });

}  // namespace
}  // namespace zoned::harness

// build: computes
// Off-screen agents that look for others: they are suspended until they may meet one, and live as
// if they had never been suspended.
#include "server/ai/offscreen/proximity_schedule.h"

#include "server/compute/worker_pool.h"
#include "tests/unit/ai/field.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>

namespace zoned::ai {
namespace {

using namespace test;

constexpr float kSight_m = 25.0F;
constexpr std::uint16_t kWatch = 0;
constexpr std::uint16_t kThief = 1;
constexpr std::uint16_t kFolk = 2;
constexpr TypeIndex kCitizen = 3;
constexpr TypeIndex kBall = 4;

/// Goes its round until it notices a thief. Then it stands and watches as long as the thief is
/// there, and walks home. It walks all of this by segments, so the result must agree to the tick.
Brain watchman() {
    Brain m;
    m.name = "watchman";
    m.perception_m = kSight_m;
    m.perception.given = true;
    m.perception.players = false;
    m.perception.targets = {kSheep, kBall};
    m.states.resize(3);
    m.states[0].name = "round";
    m.states[0].action = ActionKind::kPatrol;
    m.states[0].radius_m = 20.0F;
    m.states[0].speed_factor = 0.5F;
    m.states[0].transitions = {{1, Sensor::kPlayerDistance, Compare::kBelow, 20.0F, 0.0F}};
    m.states[1].name = "look";
    m.states[1].transitions = {{2, Sensor::kTargetConfidence, Compare::kBelow, 0.5F, 0.4F}};
    m.states[2].name = "home";
    m.states[2].action = ActionKind::kReturn;
    m.states[2].transitions = {{0, Sensor::kHomeDistance, Compare::kBelow, 2.0F, 0.0F},
                               {1, Sensor::kFoes, Compare::kAbove, 0.5F, 0.0F}};
    return m;
}

/// Wanders far and wide, and looks for no one.
Brain thief() {
    Brain m = single(ActionKind::kWander, 80.0F);
    m.name = "thief";
    m.states[0].transitions = {{1, Sensor::kTimeInState, Compare::kAbove, 40.0F, 0.0F}};
    m.states.emplace_back();
    m.states[1].name = "hide";
    m.states[1].transitions = {{0, Sensor::kRandom, Compare::kBelow, 0.02F, 0.0F}};
    return m;
}

Brain folk() {
    Brain m = single(ActionKind::kWander, 30.0F);
    m.name = "folk";
    m.states[0].speed_factor = 0.6F;
    return m;
}

struct Encountered {
    Tick tick;
    std::uint16_t state;

    friend bool operator==(const Encountered&, const Encountered&) = default;
};

using LivedThrough = std::vector<Encountered>;

/// Watchmen on a grid of 90 m, thieves among them, and others who matter to neither.
class Town {
  public:
    static constexpr std::uint32_t kWatchmen = 16;
    static constexpr std::uint32_t kThieves = 6;
    static constexpr std::uint32_t kPeople = 20;
    static constexpr std::uint32_t kAll = kWatchmen + kThieves + kPeople;

    /// `layout_of`: where thieves and people begin, by this seed.
    explicit Town(bool simulated, std::uint64_t layout_of = 5) : layout(layout_of) {
        field.types.push_back(field.types[kSheep]);
        field.types.emplace_back();  // a prop
        field.types[kSheep].character.speed = 3.0F;
        field.settings.brains = {watchman(), thief(), folk()};
        field.settings.viewer_range_m = simulated ? std::numeric_limits<float>::infinity() : 60.0F;
        compile(field.settings, kDt);
        for (std::uint32_t id = 1; id <= kAll; ++id) {
            add(id);
        }
    }

    void add(std::uint32_t id) {
        const bool watches = id <= kWatchmen;
        const bool steals = !watches && id <= kWatchmen + kThieves;
        core::Rng rng(layout, id);
        const float z = rng.range(0.0F, 270.0F);
        const float x = rng.range(0.0F, 270.0F);
        const Vec3 at = watches ? Vec3(90.0F * static_cast<float>((id - 1) % 4),
                                       0.9F,
                                       90.0F * static_cast<float>((id - 1) / 4))
                                : Vec3(x, 0.9F, z);
        add(id,
            watches ? kGuard : (steals ? kSheep : kCitizen),
            watches ? kWatch : (steals ? kThief : kFolk),
            at);
    }

    void add(std::uint32_t id, TypeIndex type, std::uint16_t brain, const Vec3& at) {
        field.add_npc(id, type, brain, at);
        const world::Row row = field.entities.find(EntityId(id));
        field.entities.set(row, world::kGrounded, true);
        field.entities.discontinuity_tick[row] = field.now;
        begin(*field.agents.find(EntityId(id)), field.settings.compiled[brain], field.now);
        lives.resize(std::max<std::size_t>(lives.size(), id + 1));
    }

    /// Moves an agent elsewhere, as a zone does it: a suspended agent is resumed.
    void teleport(std::uint32_t id, const Vec3& to) {
        const world::Row row = field.entities.find(EntityId(id));
        Agent& agent = *field.agents.find(EntityId(id));
        if (agent.tier == Tier::kSuspended) {
            resume(agent, field.settings.compiled[agent.brain], field.context(), row);
            field.agents.resume(EntityId(id));
        }
        field.entities.position[row] = to;
        field.entities.discontinuity_tick[row] = field.now;
    }

    void step() {
        if (script) {
            script(*this);
        }
        field.step();
        active += field.agents.active().size();
        for (std::uint32_t id = 1; id < lives.size(); ++id) {
            const Agent* const agent = field.agents.find(EntityId(id));
            if (agent == nullptr) {
                continue;
            }
            LivedThrough& life = lives[id];
            if (life.empty() || life.back().state != agent->state_machine.leaf) {
                life.push_back({field.now, agent->state_machine.leaf});
            }
        }
    }

    void run(float seconds) {
        const Tick end = field.now + static_cast<Tick>(seconds / kDt);
        while (field.now < end) {
            step();
        }
    }

    /// The place that an agent's own state gives.
    [[nodiscard]] Vec2 at(std::uint32_t id) {
        const Vec3& body = field.position(id);
        return whereabouts(*field.agents.find(EntityId(id)), {body.x(), body.z()}, field.now, kDt);
    }

    Field field;
    std::uint64_t layout = 5;
    std::vector<LivedThrough> lives;
    std::uint64_t active = 0;
    std::function<void(Town&)> script;
};

std::size_t entered(const Town& town, std::uint32_t first, std::uint32_t last) {
    std::size_t sum = 0;
    for (std::uint32_t id = first; id <= last; ++id) {
        sum += town.lives[id].size() - 1;
    }
    return sum;
}

/// Runs both. Returns the first agent that lived differently; 0: none.
std::uint32_t first_other(Town& all, Town& some, float seconds) {
    const Tick end = all.field.now + static_cast<Tick>(seconds / kDt);
    while (all.field.now < end) {
        all.step();
        some.step();
        for (std::uint32_t id = 1; id < all.lives.size(); ++id) {
            if (all.lives[id] != some.lives[id]) {
                return id;
            }
        }
    }
    return 0;
}

/// Suspended agents within sight of an agent that they look for, or that looks for them. All pairs
/// are checked.
std::uint32_t asleep_in_sight(Town& town) {
    const AgentStore& agents = town.field.agents;
    std::uint32_t found = 0;
    for (std::size_t a = 0; a < agents.size(); ++a) {
        const Agent& watch = agents.at(agents.nth(a));
        for (std::size_t b = 0; b < agents.size() && watch.brain == kWatch; ++b) {
            const Agent& other = agents.at(agents.nth(b));
            const bool sleeps = watch.tier == Tier::kSuspended || other.tier == Tier::kSuspended;
            if (other.brain == kThief && sleeps &&
                (town.at(watch.entity.value) - town.at(other.entity.value)).norm() < kSight_m) {
                ++found;
            }
        }
    }
    return found;
}

void expect_same_lives(Town& all, Town& some, float seconds) {
    const std::uint32_t other = first_other(all, some, seconds);
    ASSERT_EQ(other, 0U) << "lived otherwise by tick " << all.field.now;
    for (std::uint32_t id = 1; id < all.lives.size(); ++id) {
        if (all.field.agents.find(EntityId(id)) != nullptr) {
            EXPECT_EQ(all.at(id), some.at(id)) << id;
        }
    }
}

TEST(ProximitySchedule, WhoLooksForOthersIsSuspendedUntilTheyComeAndLivesTheSameToTheTick) {
    Town all(true);
    Town some(false);
    expect_same_lives(all, some, 600.0F);
    EXPECT_GT(entered(some, 1, Town::kWatchmen), 100U) << "watchmen met thieves";
    // An agent nearer than sight plus both agents' walk in a while is active, others are not.
    EXPECT_LT(some.active, all.active / 2);
}

TEST(ProximitySchedule, FindNobodySuspendedWhomAnybodyCouldPerceive) {
    Town some(false);
    std::uint64_t in_sight = 0;
    some.script = [&in_sight](Town& town) {
        in_sight += asleep_in_sight(town);
    };
    some.run(300.0F);
    EXPECT_EQ(in_sight, 0U);
}

/// Walls across the town with a gate every 30 m; every other gate shuts every 10 s.
motion::StaticGeometry gated() {
    std::vector<motion::StaticBox> walls;
    std::vector<motion::Door> gates;
    const auto piece = [](float x, float z, float half_length) {
        motion::StaticBox box;
        box.centre = Vec3(x, 1.0F, z);
        box.half_extents = Vec3(0.3F, 2.0F, half_length);
        return box;
    };
    for (const float x : {25.0F, 65.0F, 115.0F, 155.0F, 205.0F, 245.0F}) {
        for (int k = 0; k < 13; ++k) {
            const float z = -45.0F + 30.0F * static_cast<float>(k);
            walls.push_back(piece(x, z, 13.0F));
            motion::Door gate;
            gate.box = piece(x, z + 15.0F, 2.0F);
            gate.times.period = 600;
            const Tick turn = k % 2 == 0 ? 600 : 300;
            gate.times.open.push_back({turn - 300, turn});
            gates.push_back(gate);
        }
    }
    return {walls, 0.0F, motion::kStaticCell_m, {}, gates};
}

/// Moves an entity that this zone knows only by its place: of another zone, or without an agent.
void move(Town& town, std::uint32_t id, TypeIndex type, const Vec3& from, const Vec3& velocity) {
    world::Entities& e = town.field.entities;
    world::Row row = e.find(EntityId(id));
    if (row == world::kNoRow) {
        row = e.add(EntityId(id), type);
        e.set(row, world::kGhost, type == kSheep);
    }
    e.position[row] = from + velocity * (static_cast<float>(town.field.now) * kDt);
    e.velocity[row] = velocity;
}

/// Suspended watchmen in whose sight a ghost is: 901 and so on.
std::uint32_t asleep_beside_ghosts(Town& town, std::uint32_t ghosts) {
    std::uint32_t found = 0;
    for (std::uint32_t ghost = 901; ghost < 901 + ghosts; ++ghost) {
        const Vec3& at = town.field.position(ghost);
        for (std::uint32_t id = 1; id <= Town::kWatchmen; ++id) {
            const bool sleeps = town.field.agents.find(EntityId(id))->tier == Tier::kSuspended;
            found += sleeps && (town.at(id) - Vec2(at.x(), at.z())).norm() < kSight_m ? 1U : 0U;
        }
    }
    return found;
}

TEST(ProximitySchedule, FindNobodySuspendedWherePathsTurnAsDoorsDo) {
    constexpr std::uint32_t kGhosts = 20;
    Town some(false);
    Brain& watch = some.field.settings.brains[kWatch];
    watch.states[0].action = ActionKind::kWander;
    watch.states[0].radius_m = 150.0F;
    watch.states[0].speed_factor = 1.0F;
    compile(some.field.settings, kDt);
    some.field.statics = gated();
    some.field.types[kGuard].brain = kWatch + 1;
    some.field.types[kSheep].brain = kThief + 1;
    some.field.types[kCitizen].brain = kFolk + 1;
    PathfindingSettings paths;
    paths.cell_m = 1.0F;
    some.field.paths =
        PathService(paths, some.field.statics, {-60, -60, 345, 345}, some.field.types, 0);
    std::uint64_t in_sight = 0;
    some.script = [&in_sight](Town& town) {
        for (std::uint32_t k = 0; k < kGhosts; ++k) {
            // Each comes along its own line every now and then.
            const float from = -60.0F - 80.0F * static_cast<float>(k);
            move(town,
                 901 + k,
                 kSheep,
                 Vec3(from, 0.9F, 14.0F * static_cast<float>(k)),
                 Vec3(2.9F, 0.0F, 0.0F));
        }
        in_sight += asleep_in_sight(town) + asleep_beside_ghosts(town, kGhosts);
    };
    some.run(200.0F);
    EXPECT_EQ(in_sight, 0U);
    EXPECT_GT(some.field.paths.counts().broken, 20U) << "gates shut before somebody";
    EXPECT_GT(entered(some, 1, Town::kWatchmen), 20U);
}

/// As if one kind of agent looked less far, or another was faster than assumed.
void look_too_late(Town& town) {
    for (std::size_t n = 0; n < town.field.agents.size(); ++n) {
        Agent& agent = town.field.agents.at(town.field.agents.nth(n));
        if (agent.tier == Tier::kSuspended && agent.next_proximity_check != kNever) {
            agent.next_proximity_check = std::max(agent.next_proximity_check, town.field.now + 150);
        }
    }
    town.field.steps.load(town.field.steps.save(), {}, town.field.agents, town.field.settings);
}

TEST(ProximitySchedule, AreMissedWhereTheBoundIsTooLate) {
    Town all(true);
    Town some(false);
    std::uint64_t in_sight = 0;
    some.script = [&in_sight](Town& town) {
        look_too_late(town);
        in_sight += asleep_in_sight(town);
    };
    EXPECT_NE(first_other(all, some, 600.0F), 0U) << "lives differ, and that is found";
    EXPECT_GT(in_sight, 0U) << "as is who sleeps in sight";
}

TEST(ProximitySchedule, WhoNeverMeetsAnybodyIsSuspendedAllTheTime) {
    Town some(false);
    for (std::uint32_t id = Town::kWatchmen + 1; id <= Town::kWatchmen + Town::kThieves; ++id) {
        some.field.agents.take(EntityId(id));
        some.field.entities.remove(some.field.entities.find(EntityId(id)));
    }
    some.run(3.0F);
    some.active = 0;
    some.run(60.0F);
    EXPECT_EQ(some.active, 0U);
}

TEST(ProximitySchedule, AreMadeAtOnceByWhoIsBornOrPutBesideASuspendedOne) {
    Town all(true);
    Town some(false);
    const auto script = [](Town& town) {
        // Odd ticks, so that no agent is due by chance.
        if (town.field.now > 0 && town.field.now % 611 == 0) {
            const auto number = static_cast<std::uint32_t>(town.field.now / 611);
            const Vec2 by = town.at(1 + number % Town::kWatchmen);
            const auto id = Town::kAll + number;
            town.add(id, kSheep, kThief, Vec3(by.x() + 8.0F, 0.9F, by.y()));
        }
        if (town.field.now > 0 && town.field.now % 677 == 0) {
            const auto number = static_cast<std::uint32_t>(town.field.now / 677);
            const Vec2 by = town.at(1 + (3 * number) % Town::kWatchmen);
            town.teleport(Town::kWatchmen + 1 + number % Town::kThieves,
                          Vec3(by.x(), 0.9F, by.y() - 8.0F));
        }
    };
    all.script = script;
    some.script = script;
    expect_same_lives(all, some, 240.0F);
    EXPECT_LT(some.active, all.active);
}

TEST(ProximitySchedule, AreMadeByGhostsAndByWhatIsThrown) {
    Town all(true);
    Town some(false);
    const auto script = [](Town& town) {
        // Along rows of watchmen: one that walks over from beyond, and a ball of 60 m/s.
        move(town, 901, kSheep, Vec3(-120.0F, 0.9F, 100.0F), Vec3(2.9F, 0.0F, 0.0F));
        move(town, 902, kBall, Vec3(-6000.0F, 0.9F, 190.0F), Vec3(60.0F, 0.0F, 0.0F));
        move(town, 903, kBall, Vec3(45.0F, 0.9F, 45.0F), Vec3::Zero());
    };
    all.script = script;
    some.script = script;
    expect_same_lives(all, some, 150.0F);
    EXPECT_GT(entered(some, 5, 12), 12U) << "they were noticed";
    EXPECT_LT(some.active, all.active / 2);
}

/// Runs after thieves; thieves run from watchmen.
Brain hunter() {
    Brain m = watchman();
    m.name = "hunter";
    m.states[1].action = ActionKind::kChase;
    m.states[1].transitions = {{2, Sensor::kHomeDistance, Compare::kAbove, 50.0F, 0.0F},
                               {2, Sensor::kTargetConfidence, Compare::kBelow, 0.5F, 0.4F}};
    m.states[2].transitions = {{0, Sensor::kHomeDistance, Compare::kBelow, 2.0F, 0.0F}};
    return m;
}

Brain runner() {
    Brain m = thief();
    m.name = "runner";
    m.perception_m = 15.0F;
    m.perception.given = true;
    m.perception.players = false;
    m.perception.targets = {kGuard};
    m.states.resize(2);
    m.states[0].transitions = {{1, Sensor::kPlayerDistance, Compare::kBelow, 12.0F, 0.0F}};
    m.states[1].action = ActionKind::kFlee;
    m.states[1].transitions = {{0, Sensor::kTargetConfidence, Compare::kBelow, 0.5F, 0.4F}};
    return m;
}

/// A chase depends on bodies, which are within 0.2 m (and a tick's distance) of their segments when
/// it begins. So it is not the same to the tick, and a chase that begins differently ends
/// differently. It does begin at the very same tick, and the number of chases is the same in
/// distribution.
TEST(ProximitySchedule, LetChasesBeginAtTheSameTickAndBeAsMany) {
    Town all(true);
    Town some(false);
    std::array<double, 2> chases{};
    for (Town* const town : {&all, &some}) {
        town->field.settings.brains = {hunter(), runner(), folk()};
        compile(town->field.settings, kDt);
        town->run(1200.0F);
        for (std::uint32_t id = 1; id <= Town::kWatchmen; ++id) {
            for (const Encountered& turn : town->lives[id]) {
                chases[town == &some ? 1 : 0] += turn.state == 1 ? 1.0 : 0.0;
            }
        }
    }
    const auto first = [](const Town& town) {
        Tick at = kNever;
        for (std::uint32_t id = 1; id <= Town::kWatchmen + Town::kThieves; ++id) {
            if (town.lives[id].size() > 1) {
                at = std::min(at, town.lives[id][1].tick);
            }
        }
        return at;
    };
    EXPECT_EQ(first(all), first(some));
    EXPECT_GT(chases[0], 100.0);
    // Counts of nearly independent chances: three standard deviations of a difference.
    EXPECT_NEAR(chases[0], chases[1], 3.0 * std::sqrt(chases[0] + chases[1]));
    EXPECT_LT(some.active, all.active / 2);
}

TEST(ProximitySchedule, KeepThoseActiveWhoCouldBePerceivedBeyondTheBorder) {
    Town town(true);
    ProximitySchedule proximity_schedule;
    PerceptionRanges& ranges = proximity_schedule.ranges();
    ASSERT_TRUE(ranges.set(town.field.settings.compiled, {}, town.field.types));
    EXPECT_FALSE(ranges.set(town.field.settings.compiled, {}, town.field.types)) << "as before";
    const auto apart = [&](float at_m) {
        std::vector<Slot> near;
        AiContext ai = town.field.context();
        ai.half_size = Vec2(102.0F, 102.0F);
        ai.shared_m = 2.0F;
        ai.now = 100;
        const ProximitySchedule::Body body{{kGuard, kWatch}, EntityId(1), Vec2(at_m, 0.0F), 4.0F};
        return proximity_schedule.apart(body, ai, near);
    };
    // 98 m is where others may live, 25 m its range of sight, 2.1 m the error of bodies. It walks
    // 0.133 m a tick, and two ticks are for caution.
    EXPECT_EQ(apart(50.0F), static_cast<Tick>(20.9F / (4.0F * kDt)) - 2);
    EXPECT_LT(apart(72.0F), ProximitySchedule::kSoon);
    EXPECT_GT(apart(0.0F), 60);
}

/// Many more agents, which decide in every tick, in one order of rows or the other.
void crowd(Town& town, bool backwards) {
    constexpr std::uint32_t kMore = 800;
    for (Brain& brain : town.field.settings.brains) {
        brain.decide_every_s = kDt;
    }
    compile(town.field.settings, kDt);
    for (std::uint32_t k = 0; k < kMore; ++k) {
        const std::uint32_t id = 1000 + (backwards ? kMore - 1 - k : k);
        core::Rng rng(9, id);
        const bool steals = id % 10 == 0;
        town.add(id,
                 steals ? kSheep : kGuard,
                 steals ? kThief : kWatch,
                 Vec3(rng.range(-400.0F, 700.0F), 0.9F, rng.range(-400.0F, 700.0F)));
    }
}

TEST(ProximitySchedule, DependNeitherOnThreadsNorOnTheOrderOfRows) {
    Town one(false);
    Town two(false);
    crowd(one, false);
    crowd(two, true);
    compute::WorkerPool pool(2);
    two.field.team.join_pool(pool);
    for (int tick = 0; tick < 600; ++tick) {
        one.step();
        two.step();
        core::StateHash a;
        core::StateHash b;
        one.field.agents.hash(a);
        two.field.agents.hash(b);
        ASSERT_EQ(a.value(), b.value()) << "tick " << tick;
    }
    EXPECT_GT(one.field.agents.active().size(), 256U) << "threads share the work";
    EXPECT_LT(one.field.agents.active().size(), one.field.agents.size() * 9 / 10);
}

/// Reads the agents of a town again into another, and compares the two for so long.
void read_again(Town& town, std::uint64_t layout, int ticks) {
    Town other(false, layout);
    other.field.now = town.field.now;
    other.field.entities = town.field.entities;
    other.field.agents = AgentStore();
    for (std::size_t n = 0; n < town.field.agents.size(); ++n) {
        other.field.agents.add(town.field.agents.at(town.field.agents.nth(n)));
    }
    other.field.steps.load(town.field.steps.save(), {}, other.field.agents, other.field.settings);
    for (int tick = 0; tick < ticks; ++tick) {
        town.step();
        other.step();
        core::StateHash a;
        core::StateHash b;
        town.field.agents.hash(a);
        other.field.agents.hash(b);
        ASSERT_EQ(a.value(), b.value()) << "layout " << layout << ", tick " << tick;
    }
}

TEST(ProximitySchedule, GoOnBitForBitWhereSuspendedOnesAreReadAgain) {
    Town town(false);
    town.run(50.0F);
    ASSERT_LT(town.field.agents.active().size(), Town::kAll);
    std::vector<Tick> looks;
    for (std::uint32_t id = 1; id <= Town::kWatchmen; ++id) {
        looks.push_back(town.field.agents.find(EntityId(id))->next_proximity_check);
    }
    EXPECT_TRUE(std::any_of(looks.begin(), looks.end(), [](Tick t) { return t != kNever; }));
    read_again(town, 5, 3000);
}

/// Some are due in the very tick, or were put off to it by the one before.
TEST(ProximitySchedule, GoOnBitForBitInWhicheverTickTheyAreReadAgain) {
    for (std::uint64_t layout = 1; layout <= 40; ++layout) {
        Town town(false, layout);
        town.run(20.0F + 0.5F * static_cast<float>(layout));
        ASSERT_NO_FATAL_FAILURE(read_again(town, layout, 60));
    }
}

}  // namespace
}  // namespace zoned::ai

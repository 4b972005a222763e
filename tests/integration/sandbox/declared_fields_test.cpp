// Declared fields from end to end: a script sets them, and clients of both codecs hold what the
// server holds, on a bad network, across zones, in hiding, and under rate limits.
#include "server/app/world/world.h"
#include "server/config/settings.h"
#include "server/zone/zone_state.h"
#include "tests/harness/game_test.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>

namespace zoned::harness {
namespace {

constexpr const char* kWorld = R"(
world { name: "fields" seed: 5 min_x_m: -40 min_z_m: -20 max_x_m: 40 max_z_m: 20 }
zones { zone_grid { columns: 2 rows: 1 } ghost_margin_m: 60 }
script { file: "fields.lua" avatar: "player" }
type {
  name: "player" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 }
  aura_m { normal: 25 } nimbus_m { normal: 25 }
  max_acceleration_mps2: 20 max_velocity_jump_mps: 15
  character { }
  field { name: "serial" number { max: 16777215 } }
  field { name: "health" number { max: 100 initial: 100 } max_changes_per_s: 5 }
  field { name: "mood" choice { value: "calm" value: "wary" value: "angry" initial: "wary" } }
  field { name: "ready" flag { initial: true } }
  field { name: "title" text { initial: "nobody" } }
}
type {
  name: "walker" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 }
  aura_m { normal: 25 }
  character { speed_mps: 4 }
  brain: "wander"
  field { name: "serial" number { max: 16777215 } }
  field { name: "health" number { min: -1 max: 1 quantum: 0.01 } }
}
type { name: "ball" sphere { radius_m: 0.2 } aura_m { normal: 25 } max_velocity_jump_mps: 15
  field { name: "title" text { } } }
type { name: "crate" box { x_m: 0.8 y_m: 0.8 z_m: 0.8 } mass_kg: 15 aura_m { normal: 25 } }
brain {
  name: "wander"
  state { name: "walk" action: WANDER radius_m: 30
    transition { to: "rest" sensor: TIME_IN_STATE compare: ABOVE threshold: 6 } }
  state { name: "rest" action: IDLE
    transition { to: "walk" sensor: TIME_IN_STATE compare: ABOVE threshold: 2 } }
}
scatter { type: "walker" count: 12 seed: 3 }
scatter { type: "ball" count: 12 seed: 1 asleep: true }
scatter { type: "crate" count: 4 seed: 2 asleep: true }
spawn { x_m: -5 z_m: 0 }
spawn { x_m: 5 z_m: 0 }
lod { radius_m: 12 position_bound_m: 0.05 orientation_bound_rad: 0.1 }
lod { position_bound_m: 0.5 orientation_bound_rad: 0.3 }
session { dev_mode_loopback: true dev_rights: [PLAY, AUDIT, FREEZE] }
audit { enabled: true period_ticks: 10 }
)";

constexpr const char* kScript = R"(
local MOODS = { "calm", "wary", "angry" }
function on_start() state.hidden = {} end
function on_leave(client, avatar) despawn(avatar) end
function on_tick()
  keep_awake(5)
  for _, id in ipairs(near(0, 0, 0, 200)) do
    if is_owned(id) then
      if field(id, "serial") == 0 then set_field(id, "serial", id) end
      if field(id, "health") and math.random(25) == 1 then
        set_field(id, "health", client_of(id) and math.random(0, 100) or math.random(-100, 100) / 100)
      end
      if client_of(id) and math.random(40) == 1 then
        set_field(id, "mood", MOODS[math.random(3)])
        set_field(id, "ready", math.random(2) == 1)
      end
      if field(id, "title") and math.random(90) == 1 then
        set_field(id, "title", string.rep("\xC3\xA9", math.random(0, 15)))
      end
      if type_of(id) == "ball" and math.random(300) == 1 then
        hide(id)
        state.hidden[id] = now() + ticks(1)
      end
    end
  end
  for id, at in pairs(state.hidden) do
    if now() >= at then
      state.hidden[id] = nil
      set_field(id, "title", "back")
      show(id, math.random(-15, 15), 1, math.random(-15, 15))
    end
  end
end
)";

class DeclaredFieldsInPlay : public GameTest, public testing::WithParamInterface<const char*> {
  protected:
    DeclaredFieldsInPlay()
        : folder_(std::filesystem::temp_directory_path() /
                  ("zoned_fields_" + std::to_string(getpid()))) {
        std::filesystem::create_directories(folder_);
        write(kWorld, kScript);
        server.config = (folder_ / "fields.txtpb").string();
        server.sets.emplace_back(std::string("replication.codec=") + GetParam());
        server.network.delay_s = 0.05;
        server.network.loss = 0.05;
        server.network.jitter_s = 0.01;
        bots.bots = 12;
        bots.seconds = 15.0;
    }

    void write(const std::string& world, const std::string& script) const {
        std::ofstream(folder_ / "fields.txtpb") << world;
        std::ofstream(folder_ / "fields.lua") << script;
    }

    ~DeclaredFieldsInPlay() override { std::filesystem::remove_all(folder_); }

  private:
    std::filesystem::path folder_;
};

INSTANTIATE_TEST_SUITE_P(Codecs,
                         DeclaredFieldsInPlay,
                         testing::Values("SHARED", "PER_CLIENT"),
                         [](const auto& instance) { return std::string(instance.param); });

/// Owners and ghosts hold the number that an entity got once, wherever it has gone since.
void expect_serials(VirtualServer& now, std::uint64_t& owned, std::uint64_t& ghosts) {
    const auto serial = wire::field_id("serial");
    for (const auto& zone : now.world().zones()) {
        const world::Entities& e = std::as_const(*zone).state().entities;
        for (world::Row row = 0; row < e.size(); ++row) {
            const wire::FieldSchema* schema = e.fields().schema(e.type[row]);
            const wire::DeclaredField* field = schema != nullptr ? schema->find(serial) : nullptr;
            if (field == nullptr) {
                continue;
            }
            const std::uint32_t code = e.field_values(row)[field->word];
            if (code != 0) {
                ASSERT_EQ(code, e.id[row].value);
                (e.has(row, world::kGhost) ? ghosts : owned) += 1;
            }
        }
    }
}

TEST_P(DeclaredFieldsInPlay, AreWhatTheServerHoldsOnABadNetwork) {
    bots.meter = true;
    server.sets.emplace_back("replication.bandwidth_meter=true");
    std::uint64_t owned = 0;
    std::uint64_t ghosts = 0;
    const auto report =
        run([&](VirtualServer& now, double) { expect_serials(now, owned, ghosts); });
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_EQ(report.converged_bots, 12U) << report.frozen_difference;
    EXPECT_GT(report.audit.field_samples, 5000U);
    EXPECT_EQ(report.audit.field_violations, 0U);
    EXPECT_GT(owned, 1000U);
    EXPECT_GT(ghosts, 1000U);
    EXPECT_GT(report.zone_changes, 0U);
    EXPECT_EQ(report.traffic.bits(wire::TrafficReason::kUnread), 0U);
    ASSERT_EQ(report.traffic.declared().size(), 5U);
    wire::TrafficTable sent;
    world->world().sum_traffic(sent);
    ASSERT_EQ(sent.declared().size(), 5U);
    for (const auto& sum : sent.declared()) {
        EXPECT_GT(sum.changes, 20U) << sum.name;
    }
}

TEST_P(DeclaredFieldsInPlay, OfTheOwnAvatarComeAsWell) {
    bots.seconds = 6.0;
    int compared = 0;
    const auto report = run([&](VirtualServer& now, double time_s) {
        if (time_s < 5.0 || compared > 0) {
            return;
        }
        for (const auto& bot : swarm->bots()) {
            const view::Entity* own = bot->view()->store().find(bot->avatar());
            ASSERT_NE(own, nullptr);
            ASSERT_FALSE(own->fields.empty());
            EXPECT_EQ(own->fields.back().words[0], bot->avatar().value);
            ++compared;
        }
        (void)now;
    });
    EXPECT_EQ(compared, 12) << reasons(report);
}

TEST_P(DeclaredFieldsInPlay, ThatAreCorruptedAreFound) {
    server.sets.emplace_back("testing.corrupt_field.probability=0.2");
    const auto report = run();
    EXPECT_FALSE(report.consistent);
    EXPECT_GT(report.audit.field_violations, 0U);
    EXPECT_TRUE(has_reason(report, "fields: ")) << reasons(report);
}

TEST_P(DeclaredFieldsInPlay, ThatAreLostAndNotSentAgainAreFound) {
    server.network.loss = 0.15;
    server.sets.emplace_back("testing.never_again=true");
    const auto report = run();
    EXPECT_FALSE(report.consistent);
    EXPECT_GT(report.audit.field_violations, 0U) << reasons(report);
}

TEST_P(DeclaredFieldsInPlay, AreTheSameForAnyNumberOfThreads) {
    bots.seconds = 4.0;
    EXPECT_EQ(difference_between_runs(), "");
}

/// The fields of kWorld, in code.
constexpr const char* kFieldsInCode = R"(
fields = {
  { type = "player", name = "serial", kind = "number", max = 16777215 },
  { type = "player", name = "health", kind = "number", max = 100, initial = 100, max_changes_per_s = 5 },
  { type = "player", name = "mood", kind = "choice", values = { "calm", "wary", "angry" }, initial = "wary" },
  { type = "player", name = "ready", kind = "flag", initial = true },
  { type = "player", name = "title", kind = "text", initial = "nobody" },
  { type = "walker", name = "serial", kind = "number", max = 16777215 },
  { type = "walker", name = "health", kind = "number", min = -1, max = 1, quantum = 0.01 },
  { type = "ball", name = "title", kind = "text" },
}
)";

class FieldsInCode : public DeclaredFieldsInPlay {
  protected:
    /// The world's digest with these fields in its script and none in its config.
    std::string digest_with(const std::string& fields, const std::string& script = kScript) {
        write(without_fields_of(kWorld), fields + script);
        return VirtualServer(server).settings().digest;
    }

    /// Field lines gone, and what closed a type on such a line is still there.
    static std::string without_fields_of(std::string world) {
        for (std::size_t at = world.find("  field {"); at != std::string::npos;
             at = world.find("  field {")) {
            const std::size_t end = world.find('\n', at);
            const std::string line = world.substr(at, end - at);
            const auto open = std::count(line.begin(), line.end(), '{');
            const auto closed = std::count(line.begin(), line.end(), '}');
            world.replace(at, end - at, std::string(static_cast<std::size_t>(closed - open), '}'));
        }
        return world;
    }
};

INSTANTIATE_TEST_SUITE_P(Codecs,
                         FieldsInCode,
                         testing::Values("SHARED", "PER_CLIENT"),
                         [](const auto& instance) { return std::string(instance.param); });

TEST_P(FieldsInCode, GiveClientsTheWorldThatFieldsOfTheConfigGive) {
    const std::string of_config = VirtualServer(server).settings().digest;
    EXPECT_EQ(digest_with(kFieldsInCode), of_config);
    EXPECT_NE(digest_with(""), of_config);
}

TEST_P(FieldsInCode, AreWhatTheServerHoldsOnABadNetwork) {
    write(without_fields_of(kWorld), std::string(kFieldsInCode) + kScript);
    bots.seconds = 8.0;
    std::uint64_t owned = 0;
    std::uint64_t ghosts = 0;
    const auto report =
        run([&](VirtualServer& now, double) { expect_serials(now, owned, ghosts); });
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_GT(report.audit.field_samples, 2000U);
    EXPECT_EQ(report.audit.field_violations, 0U);
    EXPECT_GT(ghosts, 300U);
}

TEST_P(FieldsInCode, WithMistakesAreRefusedByTypeAndName) {
    const auto refused = [&](const std::string& field) {
        try {
            digest_with("fields = { { " + field + " } }\n", "");
        } catch (const std::runtime_error& error) {
            return std::string(error.what());
        }
        return std::string("nothing was refused");
    };
    EXPECT_EQ(refused("type = 'dragon', name = 'fire', kind = 'flag'"),
              "field 'fire' is declared for 'dragon', a type that there is not");
    EXPECT_EQ(refused("type = 'player', name = 'x', kind = 'number', max = 1, quantum = 0.3"),
              "type 'player': field 'x': a range has 1..16777215 whole steps of its quantum");
    EXPECT_EQ(refused("type = 'ball', name = 'x', kind = 'number', max = 5, initial = 9"),
              "type 'ball': field 'x': the initial value is beyond the range");
    EXPECT_EQ(refused("type = 'ball', name = 'x', kind = 'choice', values = { 'a', 'b' }, "
                      "initial = 'c'"),
              "type 'ball': field 'x': the initial value is beyond the range");
    EXPECT_EQ(refused("type = 'ball', name = '', kind = 'flag'"),
              "type 'ball': field '': a name is 1..32 bytes of UTF-8");
    EXPECT_EQ(refused("type = 'ball', name = 'x', kind = 'text', initial = '" +
                      std::string(40, 'a') + "'"),
              "type 'ball': field 'x': a text is at most 31 bytes of UTF-8");
    write(kWorld, std::string("fields = { { type = 'ball', name = 'title', kind = 'flag' } }\n"));
    EXPECT_THROW(VirtualServer{server}, std::runtime_error) << "the config declares it, too";
}

}  // namespace
}  // namespace zoned::harness

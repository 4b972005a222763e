// ScriptZone: a script on a FakeContext, and what it logged.
#pragma once

#include "server/scripting/script_rules.h"
#include "tests/unit/rules/fake_context.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace zoned::scripting::test {

using rules::test::FakeContext;
using rules::test::kBall;
using rules::test::kCrate;
using rules::test::kPlayer;

class ScriptZone final : public FakeContext {
  public:
    explicit ScriptZone(const std::string& source,
                        ScriptSettings with = {},
                        std::uint16_t zone_number = 1)
        : FakeContext(zone_number),
          settings(std::move(with)) {
        settings.name = "game.lua";
        settings.source = source;
        start();
        rules->on_start(*this);
    }

    /// Rules anew, which know nothing.
    void start() {
        rules = std::make_unique<ScriptRules>(
            settings, zone::RulesSettings{{"greeting", "hello"}}, types(), script_log());
    }

    /// A fresh interpreter and the state so far.
    void restart() {
        zone::Bytes bytes;
        ASSERT_TRUE(rules->save(bytes));
        start();
        ASSERT_EQ(rules->load(bytes), "");
    }

    void tick(int count = 1) {
        for (int i = 0; i < count; ++i) {
            for (const zone::DueTimer& timer : take_due()) {
                rules->on_timer(*this, timer);
            }
            rules->on_tick(*this);
            pass_tick();
        }
    }

    EntityId join(std::uint32_t client, const Vec3& at = Vec3::Zero()) {
        return rules->on_join(
            *this, {ClientId(client), "name" + std::to_string(client), "red", at, "account"});
    }

    EntityId put(TypeIndex type, const Vec3& at) {
        zone::SpawnDef def;
        def.type = type;
        def.position = at;
        return spawn(def);
    }

    void command(std::uint32_t client,
                 EntityId avatar,
                 std::uint16_t kind,
                 std::string_view bytes) {
        rules->on_command(*this,
                          ClientId(client),
                          avatar,
                          kind,
                          {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
    }

    [[nodiscard]] std::uint64_t hash() const {
        core::StateHash all;
        rules->hash(all);
        hash_columns(all);
        return all.value();
    }

    /// The printed lines, between bars.
    [[nodiscard]] std::string printed() const { return joined(printed_); }

    [[nodiscard]] std::string errors() const { return joined(errors_); }

    void clear() {
        printed_.clear();
        errors_.clear();
    }

    ScriptSettings settings;
    std::unique_ptr<ScriptRules> rules;

  private:
    ScriptLog script_log() {
        return [this](ScriptLine kind, const std::string& line) {
            (kind == ScriptLine::kError ? errors_ : printed_).push_back(line);
        };
    }

    static std::string joined(const std::vector<std::string>& lines) {
        std::string all;
        for (const std::string& line : lines) {
            all += (all.empty() ? "" : "|") + line;
        }
        return all;
    }

    std::vector<std::string> printed_;
    std::vector<std::string> errors_;
};

/// Expressions as print() shows them, in one call of on_tick.
inline std::string printed_by(const std::string& statements) {
    ScriptZone zone("function on_tick() " + statements + " end");
    zone.tick();
    EXPECT_EQ(zone.errors(), "");
    return zone.printed();
}

/// The error that statements end with.
inline std::string error_of(const std::string& statements, const ScriptSettings& settings = {}) {
    ScriptZone zone("function on_tick() " + statements + " end", settings);
    zone.tick();
    EXPECT_EQ(zone.rules->errors(), 1u);
    return zone.errors();
}

/// Why a source is refused; empty: it is not.
inline std::string refusal_of(const std::string& source, const ScriptSettings& settings = {}) {
    try {
        ScriptZone zone(source, settings);
        return "";
    } catch (const std::exception& refused) {
        return refused.what();
    }
}

}  // namespace zoned::scripting::test

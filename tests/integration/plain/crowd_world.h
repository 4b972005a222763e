// CrowdWorld: a world of one zone from a config's text, with walkers at the places a test wants.
#pragma once

#include "server/app/world/world.h"
#include "server/config/expand/load_settings.h"
#include "server/zone/zone_state.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace zoned::app::test {

inline constexpr float kRadius = 0.4F;

/// Replaces the part `from` of `text`, once.
inline std::string with(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}

class Crowd {
  public:
    explicit Crowd(const std::string& text, unsigned threads = 1)
        : settings_(read(text)),
          world_(settings_, threads) {}

    Crowd(const std::string& text, const std::vector<std::pair<std::string, Vec2>>& walkers)
        : settings_(with(read(text), walkers)),
          world_(settings_, 1) {}

    void tick() {
        world_.tick({}, out_);
        out_.clear();
    }

    [[nodiscard]] zone::ZoneState& state() { return world_.zones().front()->state(); }

    [[nodiscard]] const ai::LocalAvoidanceReport& avoidance() {
        return world_.zones().front()->report().ai.avoidance;
    }

    [[nodiscard]] World& world() { return world_; }

    /// x, z of the n-th entity.
    [[nodiscard]] Vec2 at(world::Row row) {
        const Vec3& p = state().entities.position[row];
        return {p.x(), p.z()};
    }

    /// The largest overlap of any two entities now, m; below 0: the gap between the nearest two.
    float overlap() {
        float most = -std::numeric_limits<float>::infinity();
        const std::size_t count = state().entities.size();
        for (world::Row a = 0; a < count; ++a) {
            for (world::Row b = 0; b < a; ++b) {
                most = std::max(most, 2.0F * kRadius - (at(a) - at(b)).norm());
            }
        }
        return most;
    }

    /// The largest depth of an entity in a static box, m.
    float in_walls() {
        float most = -std::numeric_limits<float>::infinity();
        for (world::Row row = 0; row < state().entities.size(); ++row) {
            for (const motion::StaticBox& box : state().settings.statics->boxes()) {
                const Vec3 local =
                    box.orientation.conjugate() * (state().entities.position[row] - box.centre);
                const Vec3 beyond = local.cwiseAbs() - box.half_extents;
                // Of the capsule's segment, 1 m high, to an upright box.
                const Vec3 out(std::max(beyond.x(), 0.0F),
                               std::max(beyond.y() - 0.5F, 0.0F),
                               std::max(beyond.z(), 0.0F));
                most = std::max(most, kRadius - out.norm());
            }
        }
        return most;
    }

  private:
    static config::Settings read(const std::string& text) {
        config::Settings settings;
        std::vector<config::ConfigError> errors;
        if (!config::parse_settings(text, {}, settings, errors)) {
            throw std::runtime_error(config::format_errors("text", errors));
        }
        return settings;
    }

    static config::Settings with(config::Settings settings,
                                 const std::vector<std::pair<std::string, Vec2>>& walkers) {
        for (const auto& [type, at] : walkers) {
            config::InitialEntity initial;
            const auto found = std::find_if(settings.types.begin(),
                                            settings.types.end(),
                                            [&](const auto& t) { return t.name == type; });
            initial.type = static_cast<TypeIndex>(found - settings.types.begin());
            initial.position = Vec3d(static_cast<double>(at.x()), 0.9, static_cast<double>(at.y()));
            settings.initial.push_back(initial);
        }
        return settings;
    }

    config::Settings settings_;
    World world_;
    std::vector<mailbox::OutboxItem> out_;
};

}  // namespace zoned::app::test

// Bots that play @GAME@.
#pragma once

#include "client-sim/bot/script.h"

#include "capture.h"

#include <cmath>
#include <memory>
#include <string>
#include <string_view>
#include <variant>

namespace capture {

/// The match as a bot heard of it.
struct Heard {
    unsigned taken = 0;
    unsigned dropped = 0;
    unsigned scored = 0;
    std::string leaderboard;
};

/// Fetches the other team's flag; every fifth bot defends: it hunts who carries its own.
class Bot final : public zoned::bot::OwnScript {
  public:
    Bot(std::size_t index, const std::string& team, std::shared_ptr<Heard> heard)
        : defends_(index % 5 == 4),
          team_(team == kTeamNames[1] ? 1 : 0),
          heard_(std::move(heard)) {}

    zoned::motion::InputCommand decide(const zoned::view::View& view,
                                       zoned::Tick tick,
                                       zoned::bot::Voice& voice) override {
        look_round(view);
        const zoned::Vec3d me = view.own().position();
        const auto [x, z] = goal();
        auto command = zoned::bot::walk_towards(x - me.x(), z - me.z());
        if (opponent_m_ < 2.2 && tick >= shove_at_) {
            voice.command(kShove, {});
            shove_at_ = tick + 245;
        }
        if (tick % 95 == 0 && std::hypot(x - me.x(), z - me.z()) > 10.0) {
            command.buttons |= kDash;
        }
        return command;
    }

    void on_event(const zoned::wire::EventMessage& event) override {
        heard_->taken += event.kind == kTaken ? 1 : 0;
        heard_->dropped += event.kind == kDropped ? 1 : 0;
        heard_->scored += event.kind == kScored ? 1 : 0;
        if (event.kind == kLeaderboard) {
            heard_->leaderboard = event.payload;
        }
    }

  private:
    struct Place {
        double x = 0.0;
        double z = 0.0;
    };

    static bool is(const zoned::view::View& view,
                   zoned::EntityId entity,
                   std::string_view field,
                   std::string_view text) {
        const auto value = view.field(entity, field);
        const auto* name = value ? std::get_if<std::string_view>(&*value) : nullptr;
        return name != nullptr && *name == text;
    }

    static bool is_set(const zoned::view::View& view,
                       zoned::EntityId entity,
                       std::string_view field) {
        const auto value = view.field(entity, field);
        const auto* truth = value ? std::get_if<bool>(&*value) : nullptr;
        return truth != nullptr && *truth;
    }

    void look_round(const zoned::view::View& view) {
        const zoned::Vec3d me = view.own().position();
        const char* const theirs = kTeamNames[1 - team_];
        opponent_m_ = 1e9;
        thief_seen_ = false;
        own_flag_seen_ = their_flag_seen_ = false;
        carries_ = is_set(view, view.own().id(), "carries");
        for (const auto& [id, entity] : view.store().entities()) {
            const auto state = id != view.own().id() ? view.on_screen(entity) : std::nullopt;
            if (!state || !entity.present() || !entity.typed) {
                continue;
            }
            const Place at{state->position.x(), state->position.z()};
            const bool is_flag = view.world().types[entity.type].name == "flag";
            if (is_flag && is(view, id, "team", theirs)) {
                their_flag_ = at;
                their_flag_seen_ = true;
            } else if (is_flag) {
                own_flag_ = at;
                own_flag_seen_ = true;
            } else if (is(view, id, "team", theirs)) {
                opponent_m_ = std::min(opponent_m_, std::hypot(at.x - me.x(), at.z - me.z()));
                if (is_set(view, id, "carries")) {
                    thief_ = at;
                    thief_seen_ = true;
                }
            }
        }
    }

    [[nodiscard]] Place goal() const {
        const Place home{kHomeX[team_], 0.0};
        const bool own_flag_away =
            !own_flag_seen_ || std::hypot(own_flag_.x - home.x, own_flag_.z) > 1.0;
        if (carries_) {
            return home;
        }
        if (own_flag_seen_ && own_flag_away) {
            return own_flag_;  // it lies: bring it back
        }
        if (thief_seen_ && (defends_ || !their_flag_seen_)) {
            return thief_;
        }
        return defends_           ? Place{home.x * 0.85, 3.0}
               : their_flag_seen_ ? their_flag_
                                  : Place{-home.x, 0.0};
    }

    bool defends_;
    std::size_t team_;
    std::shared_ptr<Heard> heard_;
    zoned::Tick shove_at_ = 0;
    double opponent_m_ = 1e9;
    bool carries_ = false;
    bool thief_seen_ = false;
    bool own_flag_seen_ = false;
    bool their_flag_seen_ = false;
    Place thief_;
    Place own_flag_;
    Place their_flag_;
};

}  // namespace capture

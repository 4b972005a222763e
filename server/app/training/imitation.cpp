#include "server/app/training/imitation.h"

#include "server/app/world/replayed_tick.h"
#include "server/app/world/world.h"
#include "server/app/world/world_rules.h"
#include "server/config/expand/load_settings.h"
#include "server/config/training/policy_file.h"
#include "server/recording/recording_reader.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

namespace zoned::app {

namespace {

namespace learning = ai::learning;
using Played = core::Result<std::vector<PlayedTick>>;
using LessonsResult = core::Result<Lessons>;

struct Player {
    std::uint32_t client = 0;
    Vec2 at = Vec2::Zero();
    Vec2 velocity = Vec2::Zero();
    motion::InputCommand command;
};

/// All players that others could see, by client.
std::vector<Player> players_of(const World& world) {
    std::vector<Player> players;
    for (const auto& zone : world.zones()) {
        const zone::ZoneState& state = zone->state();
        const world::Entities& e = state.entities;
        const Vec3d origin = state.settings.region().origin();
        for (world::Row row = 0; row < e.size(); ++row) {
            if (!e.client[row] || e.has(row, world::kGhost) || e.has(row, world::kHidden)) {
                continue;
            }
            const Vec3d at = origin + e.position[row].cast<double>();
            players.push_back({e.client[row].value,
                               Vec2(static_cast<float>(at.x()), static_cast<float>(at.z())),
                               Vec2(e.velocity[row].x(), e.velocity[row].z()),
                               e.command[row]});
        }
    }
    std::sort(players.begin(), players.end(), [](const Player& a, const Player& b) {
        return a.client < b.client;
    });
    return players;
}

learning::Wanted wanted_of(const motion::InputCommand& command) {
    learning::Wanted wanted;
    wanted.move = Vec2(command.move_x, command.move_z) / 127.0F;
    const float length = wanted.move.norm();
    if (length > 1.0F) {
        wanted.move /= length;
    }
    wanted.sprint = (command.buttons & motion::kButtonSprint) != 0;
    return wanted;
}

/// Goes through a recording and keeps the actions of players.
class PlayerObserver {
  public:
    PlayerObserver(const proto::Training::Imitation& settings, std::uint32_t every_ticks)
        : settings_(settings),
          every_(every_ticks) {}

    void see(const World& world, Tick tick) {
        std::vector<Player> now = players_of(world);
        for (const Player& player : now) {
            first_.try_emplace(player.client, player.at);
            const auto before =
                std::lower_bound(before_.begin(),
                                 before_.end(),
                                 player.client,
                                 [](const Player& p, std::uint32_t c) { return p.client < c; });
            // The situation before the tick: the player's input answered to it.
            if (tick % every_ == 0 && before != before_.end() && before->client == player.client) {
                ticks.push_back({player.client, situation_of(*before), wanted_of(player.command)});
            }
        }
        before_ = std::move(now);
    }

    std::vector<PlayedTick> ticks;

  private:
    [[nodiscard]] learning::Situation situation_of(const Player& player) const {
        learning::Situation s;
        s.here = player.at;
        s.velocity = player.velocity;
        s.home = settings_.has_home() ? Vec2(static_cast<float>(settings_.home().x_m()),
                                             static_cast<float>(settings_.home().z_m()))
                                      : first_.at(player.client);
        auto nearest = static_cast<float>(settings_.perception_m());
        for (const Player& other : before_) {
            const float distance = (other.at - player.at).norm();
            if (other.client != player.client && distance < nearest) {
                nearest = distance;
                s.has_target = true;
                s.target = other.at;
                s.target_velocity = other.velocity;
            }
        }
        return s;
    }

    const proto::Training::Imitation& settings_;
    Tick every_;
    std::map<std::uint32_t, Vec2> first_;  ///< where each client was first
    std::vector<Player> before_;
};

std::string text_of(const std::vector<config::ConfigError>& errors, const std::string& file) {
    return config::format_errors(file + " (its config)", errors);
}

}  // namespace

Played played_ticks(const proto::Training::Imitation& settings, std::uint32_t every_ticks) {
    recording::RecordingReader reader;
    const auto opened = reader.open(settings.recording());
    if (!opened) {
        return Played::failure(opened.error());
    }
    const auto comparable = reader.check_build();
    if (!comparable) {
        return Played::failure(comparable.error());
    }
    config::Settings config;
    std::vector<config::ConfigError> errors;
    if (!config::parse_settings(reader.header().config_text, {}, config, errors)) {
        return Played::failure(text_of(errors, settings.recording()));
    }
    declare_fields(config);
    World world(config, 1);
    const std::string bad_state = begin_with_state(reader, world);
    if (!bad_state.empty()) {
        return Played::failure(settings.recording() + ": " + bad_state);
    }
    PlayerObserver observer(settings, every_ticks);
    recording::TickRecord record;
    for (;;) {
        const auto next = reader.next(record);
        if (!next) {
            return Played::failure(next.error());
        }
        if (!*next) {
            return std::move(observer.ticks);
        }
        const std::string wrong = replayed_tick(config, record, true, world);
        if (!wrong.empty()) {
            return Played::failure(settings.recording() +
                                   " does not go as it was recorded: " + wrong);
        }
        observer.see(world, record.tick);
    }
}

LessonsResult lessons_of(const std::vector<PlayedTick>& ticks,
                         const proto::Training::Imitation& settings) {
    std::set<std::uint32_t> clients;
    for (const PlayedTick& tick : ticks) {
        clients.insert(tick.client);
    }
    if (clients.size() < 2) {
        return LessonsResult::failure(settings.recording() + " holds " +
                                      std::to_string(clients.size()) +
                                      " players; two are needed, one to learn from and one to "
                                      "judge by");
    }
    learning::Policy policy;
    policy.facing = static_cast<learning::Facing>(settings.facing());
    policy.inputs = config::inputs_of(settings.input());
    Lessons lessons;
    lessons.players = clients.size();
    lessons.players_held_out = std::clamp<std::size_t>(
        static_cast<std::size_t>(
            std::lround(settings.held_out() * static_cast<double>(clients.size()))),
        1,
        clients.size() - 1);
    const std::uint32_t first_held_out =
        *std::prev(clients.end(), static_cast<std::ptrdiff_t>(lessons.players_held_out));
    const std::size_t outputs = settings.sprint() ? 3 : 2;
    for (learning::Samples* samples : {&lessons.training, &lessons.held_out}) {
        samples->inputs = policy.inputs.size();
        samples->outputs = outputs;
    }
    std::vector<float> in(policy.inputs.size());
    core::StateHash hash;
    for (const PlayedTick& tick : ticks) {
        sense(policy, tick.situation, {}, in);
        const auto out = outputs_for(policy.facing, tick.situation, tick.wanted);
        const std::span<const float> wanted(out.data(), outputs);
        (tick.client < first_held_out ? lessons.training : lessons.held_out).add(in, wanted);
        for (const std::span<const float> numbers : {std::span<const float>(in), wanted}) {
            for (const float number : numbers) {
                hash.add(number);
            }
        }
    }
    lessons.hash = hash.value();
    return lessons;
}

}  // namespace zoned::app

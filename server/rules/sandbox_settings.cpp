#include "server/rules/sandbox_settings.h"

#include "shared/core/files/line_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace zoned::rules {

namespace {

struct Number {
    std::string_view name;
    float GameSettings::*field;
    float least;
    float most;
};

constexpr std::array kNumbers = {
    Number{"health", &GameSettings::health, 1.0F, 10000.0F},
    Number{"damage", &GameSettings::damage, 1.0F, 10000.0F},
    Number{"shot_cooldown_s", &GameSettings::shot_cooldown_s, 0.01F, 60.0F},
    Number{"shot_range_m", &GameSettings::shot_range_m, 1.0F, 1000.0F},
    Number{"shot_impulse_ns", &GameSettings::shot_impulse_ns, 0.0F, 1000.0F},
    Number{"confirm_s", &GameSettings::confirm_s, 0.1F, 60.0F},
    Number{"respawn_s", &GameSettings::respawn_s, 0.1F, 3600.0F},
    Number{"pickup_kg", &GameSettings::pickup_kg, 0.0F, 1000.0F},
    Number{"pickup_range_m", &GameSettings::pickup_range_m, 0.5F, 20.0F},
    Number{"inventory", &GameSettings::inventory, 1.0F, 64.0F},
    Number{"throw_mps", &GameSettings::throw_mps, 1.0F, 100.0F},
    Number{"throw_cooldown_s", &GameSettings::throw_cooldown_s, 0.01F, 60.0F},
    Number{"push_mps", &GameSettings::push_mps, 0.1F, 50.0F},
    Number{"push_range_m", &GameSettings::push_range_m, 0.5F, 20.0F},
    Number{"push_cooldown_s", &GameSettings::push_cooldown_s, 0.01F, 60.0F},
    Number{"impact_mps", &GameSettings::impact_mps, 1.0F, 100.0F},
    Number{"impact_damage_per_ns", &GameSettings::impact_damage_per_ns, 0.0F, 100.0F},
    Number{"impact_knock_mps", &GameSettings::impact_knock_mps, 0.0F, 50.0F},
    Number{"debris_count", &GameSettings::debris_count, 0.0F, 1000.0F},
    Number{"hail_damage", &GameSettings::hail_damage, 0.0F, 10000.0F},
    Number{"ride_range_m", &GameSettings::ride_range_m, 0.5F, 20.0F},
    Number{"ragdoll_s", &GameSettings::ragdoll_s, 0.1F, 3600.0F},
    Number{"chat_per_s", &GameSettings::chat_per_s, 0.1F, 100.0F},
    Number{"chat_burst", &GameSettings::chat_burst, 1.0F, 100.0F},
    Number{"bite_damage", &GameSettings::bite_damage, 0.0F, 10000.0F},
    Number{"bite_range_m", &GameSettings::bite_range_m, 0.5F, 20.0F},
    Number{"bite_cooldown_s", &GameSettings::bite_cooldown_s, 0.01F, 60.0F},
};

[[noreturn]] void refuse(const std::string& name, const std::string& why) {
    throw std::runtime_error("rules setting \"" + name + "\": " + why);
}

float number_of(const Number& number, const std::string& text) {
    const float value = core::parse_number<float>(text).value_or(NAN);
    if (!std::isfinite(value)) {
        refuse(std::string(number.name), "\"" + text + "\" is not a number");
    }
    if (value < number.least || value > number.most) {
        refuse(std::string(number.name),
               text + " is not in [" + std::to_string(number.least) + ", " +
                   std::to_string(number.most) + "]");
    }
    return value;
}

const world::EntityType& need_type(const std::string& setting,
                                   const std::string& type,
                                   const world::TypeTable& types) {
    const auto it = std::find_if(
        types.begin(), types.end(), [&](const world::EntityType& t) { return t.name == type; });
    if (it == types.end()) {
        refuse(setting, "the world has no entity type \"" + type + "\"");
    }
    return *it;
}

void need_character(const std::string& setting,
                    const std::string& type,
                    const world::TypeTable& types) {
    if (need_type(setting, type, types).kind != world::EntityKind::kCharacter) {
        refuse(setting, "entity type \"" + type + "\" is not a character");
    }
}

void need_prop(const std::string& setting, const std::string& type, const world::TypeTable& types) {
    if (need_type(setting, type, types).kind != world::EntityKind::kProp) {
        refuse(setting, "entity type \"" + type + "\" is not a prop");
    }
}

}  // namespace

GameSettings parse_settings(const zone::RulesSettings& settings, const world::TypeTable& types) {
    GameSettings game;
    for (const auto& [name, value] : settings) {
        if (name == "player_type") {
            game.player_type = value;
            continue;
        }
        if (name == "bite_type") {
            game.bite_type = value;
            continue;
        }
        if (name == "ragdoll_type") {
            game.ragdoll_type = value;
            continue;
        }
        if (name == "debris_system" || name == "hail_system") {
            (name == "hail_system" ? game.hail_system : game.debris_system) = value;
            continue;
        }
        const auto number = std::find_if(
            kNumbers.begin(), kNumbers.end(), [&](const Number& n) { return n.name == name; });
        if (number == kNumbers.end()) {
            refuse(name, "the sandbox game has no such setting");
        }
        game.*(number->field) = number_of(*number, value);
    }
    need_character("player_type", game.player_type, types);
    if (!game.bite_type.empty()) {
        need_character("bite_type", game.bite_type, types);
    }
    if (!game.ragdoll_type.empty()) {
        need_prop("ragdoll_type", game.ragdoll_type, types);
    }
    return game;
}

}  // namespace zoned::rules

// Settings of the sandbox game, from the free-form `rules` entries of the config.
#pragma once

#include "server/zone/rules.h"

#include <string>

namespace zoned::rules {

struct GameSettings {
    std::string player_type = "player";  ///< entity type of avatars: a character
    float health = 100.0F;               ///< of every character, [1, 10000]

    float damage = 20.0F;           ///< of one shot, [1, 10000]
    float shot_cooldown_s = 0.25F;  ///< [0.01, 60]
    float shot_range_m = 100.0F;    ///< [1, 1000]
    float shot_impulse_ns = 5.0F;   ///< that a shot gives to a prop, N s, [0, 1000]
    float confirm_s = 3.0F;  ///< how long a kill waits for the killed client's word, [0.1, 60]
    float respawn_s = 5.0F;  ///< [0.1, 3600]

    float pickup_kg = 10.0F;      ///< props lighter than this can be carried, [0, 1000]
    float pickup_range_m = 2.5F;  ///< [0.5, 20]
    float inventory = 8.0F;       ///< most items carried, [1, 64]
    float throw_mps = 12.0F;      ///< [1, 100]
    float throw_cooldown_s = 0.25F;
    float push_mps = 3.0F;      ///< change of velocity, [0.1, 50]
    float push_range_m = 2.0F;  ///< [0.5, 20]
    float push_cooldown_s = 0.5F;

    float impact_mps = 6.0F;            ///< thrown props faster than this hurt, [1, 100]
    float impact_damage_per_ns = 0.4F;  ///< [0, 100]
    float impact_knock_mps = 4.0F;      ///< most that a thrown prop knocks a character, [0, 50]

    std::string debris_system =
        "debris";                ///< particles with a burst that hits throw up; may be missing
    float debris_count = 12.0F;  ///< particles of a hit, [0, 1000]
    std::string hail_system;     ///< simulated particles that hurt players; empty: none
    float hail_damage = 0.0F;    ///< of each one within 1 m, some four times a second, [0, 10000]

    float ride_range_m = 3.0F;  ///< [0.5, 20]

    std::string ragdoll_type;  ///< a prop that a killed character becomes; empty: none
    float ragdoll_s = 8.0F;    ///< how long it lies there, [0.1, 3600]

    float chat_per_s = 2.0F;  ///< [0.1, 100]
    float chat_burst = 5.0F;  ///< [1, 100]

    std::string bite_type;     ///< characters that bite players while they run at them; empty: none
    float bite_damage = 0.0F;  ///< [0, 10000], 0 = nobody bites
    float bite_range_m = 1.5F;  ///< [0.5, 20]
    float bite_cooldown_s = 1.0F;
};

/// Throws std::runtime_error that names the entry. Causes: a name is unknown, a value is not a
/// number or out of range, or a type is missing from `types` or not a character.
GameSettings parse_settings(const zone::RulesSettings& settings, const world::TypeTable& types);

}  // namespace zoned::rules

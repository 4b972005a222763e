// WorldLife: the name of a world's unbroken course of ticks, so that a server which goes on from a
// kept state knows whether another one has had the world since.
#pragma once

#include "server/config/settings.h"

#include <cstddef>
#include <string>

namespace zoned::app {

inline constexpr std::size_t kLifeBytes = 16;

/// Of the state that lies in the folder `journal` of the state folder; empty: it has no name, or
/// there is none.
[[nodiscard]] std::string kept_life(const config::Settings& settings);

/// Written and synced before a state of that life is; empty: none is noted. Throws
/// std::runtime_error where the folder cannot be written.
void note_life(const config::Settings& settings, const std::string& life);

}  // namespace zoned::app

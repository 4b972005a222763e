// The files of a new game, as `zoned new` writes them. They lie in config/templates.
#pragma once

#include <cstdint>
#include <span>

namespace zoned::app {

enum class NewGame : std::uint8_t {
    kCpp,             ///< tag
    kLua,             ///< tag
    kCaptureTheFlag,  ///< in C++
};

struct GameTemplate {
    NewGame game = NewGame::kCpp;
    const char* path = "";  ///< within the game's folder
    const char* text = "";  ///< @GAME@ stands for the game's name
};

std::span<const GameTemplate> game_templates();

}  // namespace zoned::app

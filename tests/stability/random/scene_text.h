// SceneText: random scenes as short text files, one body, part or joint a line.
#pragma once

#include "tests/stability/random/random_scene.h"

#include <string>
#include <string_view>

namespace zoned::stability {

inline constexpr std::size_t kMostSceneTextBytes = 4U << 20;

/// The first line is `zoned-scene 1`. Each further line is a name and settings in any order, a
/// setting being a word and its numbers: `body dynamic mass 2 at 0 1 0`, below it at least one
/// `part box half 1 0.5 1`. Settings with their default value are left out. `#` begins a comment.
std::string scene_to_text(const RandomScene& scene);

/// The very scene that was written, to the last bit. Takes any bytes: fails with line and reason
/// where a word is unknown, missing or given twice, a number is none or not finite, or there is too
/// much of something. Numbers in range and sound places are why_unsound's part.
core::Result<RandomScene> scene_from_text(std::string_view text);

}  // namespace zoned::stability

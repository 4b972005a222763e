// Reach: whether a program uses each source of the product, read from the include lines.
#pragma once

#include "tests/lint/check.h"

#include <vector>

namespace zoned::lint {

/// Each header, source and kernel of server, client-sim, shared and kernels is reached from
/// server/main.cpp, client-sim/main.cpp, the shared object's client-sim/library/zoned_client.cpp or
/// the browser module's client-sim/web/web_client.cpp. The extension for Godot is in C, and its
/// header stands for it.
/// - A reached file reaches the headers that it includes.
/// - A reached header reaches its sources. A source belongs to the header of the same name beside
///   it; else to the headers beside it that it includes and whose names begin with the most of the
///   words that its own name begins with; else to every header beside it that it includes; else to
///   the first header that it includes.
/// - A source reaches the kernels whose paths it names in quotes.
/// - Sources of server/rules register themselves: the linker takes them as a whole.
/// A file whose opening comment says kUnreachedNote is left out, and a source all of whose headers
/// say it. A note on what is reached is a finding too.
[[nodiscard]] std::vector<Finding> check_reached(const std::vector<SourceFile>& files);

inline constexpr std::string_view kUnreachedNote = "Reached by no program yet: ";

}  // namespace zoned::lint

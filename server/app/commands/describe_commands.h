// Descriptions of the command line for other programs, made from the command line itself: bash
// completion and the manual page.
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace zoned::app {

/// A script that completes commands, options and the values of those that have a list.
[[nodiscard]] std::string bash_completion(const CLI::App& app);

/// A manual page of section 1, in the macros of man(7).
[[nodiscard]] std::string manual_page(const CLI::App& app);

}  // namespace zoned::app

// play: takes a page's steps as its reader would, in a copy of the repository in which `build` is
// the folder that holds the built programs.
#pragma once

#include "tests/pages/page.h"

#include <filesystem>
#include <string>
#include <vector>

namespace zoned::pages {

struct Stage {
    std::filesystem::path root;  ///< of the copy: where the page is read from and its reader stands
    std::filesystem::path scratch;  ///< for logs, outside of the copy
};

struct Played {
    std::vector<Finding> failures;
    std::vector<Finding> skipped;    ///< with their reasons
    std::vector<Finding> shortened;  ///< ran with less than the page says
    int commands = 0;                ///< blocks that were run
};

/// Makes `scratch`/zoned a copy of the repository's tracked top level in `source`, with `build`
/// linked there. Nothing that an earlier page left in `scratch` stays.
Stage set_stage(const std::filesystem::path& source,
                const std::filesystem::path& build,
                const std::filesystem::path& scratch);

Played play(const Page& page, const Stage& stage);

/// Paths, links, programs and their options that a page names and that do not exist.
std::vector<Finding> wrong_mentions(const Page& page, const Stage& stage);

}  // namespace zoned::pages

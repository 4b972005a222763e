// Page: the report as one HTML file that needs no other.
#pragma once

#include "tests/bench/results.h"

#include <cstddef>
#include <string>

namespace zoned::bench {

/// A page is never larger; pictures of scenes are left out where they don't fit, which it says.
inline constexpr std::size_t kLargestPage = 2'000'000;

/// Summary, plots with tables, growth, bandwidth, pictures. `generated_by` is the command line.
std::string report_html(const Results& results, const std::string& generated_by);

/// The summary as an SVG picture: per scene with a peer the time over the front of our default, of
/// the best of ours and of the best peer.
std::string summary_svg(const Results& results);

/// Files of the page, from the build (report/embed.cmake).
struct PageFiles {
    const char* style;
    const char* script;
    const char* charts;  ///< Chart.js
};

PageFiles page_files();

}  // namespace zoned::bench

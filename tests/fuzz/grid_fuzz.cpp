// Fuzzing of grid maps and scenarios: any text is refused with a line, or gives a map on which all
// exact methods agree.
#include "server/ai/navigation/grid_text.h"
#include "server/ai/navigation/planner.h"
#include "tests/fuzz/fuzz.h"
#include "shared/core/assert.h"

#include <string_view>

namespace zoned::fuzz {

namespace {

using namespace ai::navigation;

constexpr std::size_t kMaxText = 20000;
/// Larger maps are read, but no ways are looked for on them.
constexpr std::uint32_t kMostPlaces = 20000;

template <class R>
bool read_or_refused(const R& result) {
    ZONED_ASSERT(result || result.error().starts_with("line "), "a refusal names the line");
    return result.ok();
}

/// From the first passable cell to some others, by all exact methods.
void use_map(const GridMap& map) {
    Planner planner(map);
    planner.prepare();
    Query query;
    bool started = false;
    std::uint32_t seen = 0;
    for (Place p = 0; p < map.places(); ++p) {
        if (!map.passable(p)) {
            continue;
        }
        query.start = started ? query.start : map.cell(p);
        started = true;
        if (seen++ % 37 != 0) {
            continue;
        }
        query.goal = map.cell(p);
        const Answer best = planner.plan(query, Method::kAStar);
        for (const Method m : {Method::kJumpPoints, Method::kSubgoals, Method::kHubLabels}) {
            if (planner.can(m)) {
                const Answer a = planner.plan(query, m);
                ZONED_ASSERT(a.outcome == best.outcome && a.cost == best.cost,
                             "exact methods agree");
            }
        }
    }
}

Bytes text_seed(std::string_view text) {
    return {text.begin(), text.end()};
}

}  // namespace

std::vector<Bytes> seeds() {
    return {
        text_seed(
            "type octile\nheight 5\nwidth 7\nmap\n.......\n.@@T.W.\n.@...G.\n.@.OO..\n...S.@.\n"),
        text_seed("type octile\r\nheight 2\r\nwidth 2\r\nmap\r\n.@\r\n..\r\n"),
        text_seed("version 1\n0\tm.map\t9\t8\t1\t2\t3\t4\t2.82843\r\n1 m 9 8 8 7 0 0 10.4\n"),
        text_seed("type patch\npatches 2\npatch 0\nheight 1\nwidth 2\nmap\n@.\npatch "
                  "1\nheight 1\nwidth 1\nmap\n.\n"),
        text_seed("version 2\nheight 4\nwidth 5\ncost 1 octile\ncommands\nQ 0 0 1 4 3 5.2\nP 0 "
                  "1 3 2\n")};
}

}  // namespace zoned::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace zoned::fuzz;
    const std::string_view text(reinterpret_cast<const char*>(data), std::min(size, kMaxText));
    const auto map = zoned::ai::navigation::parse_grid_map(text);
    if (read_or_refused(map) && map->places() <= kMostPlaces) {
        use_map(*map);
    }
    read_or_refused(zoned::ai::navigation::parse_grid_scenario(text));
    read_or_refused(zoned::ai::navigation::parse_grid_patches(text));
    read_or_refused(zoned::ai::navigation::parse_grid_events(text));
    return 0;
}

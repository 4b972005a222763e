#include "tests/scenario/grid_text.h"

#include "server/ai/pathfinding/grid/cost.h"
#include "shared/core/files/line_reader.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace zoned::scenario {

namespace {

/// Longest path that a scenario may claim, cells: more than any map has.
constexpr double kLongest = 1e9;
constexpr int kMostPatches = 1'000'000;

/// Reads the words of a line as the formats of grids have them.
class GridReader : public core::LineReader {
  public:
    explicit GridReader(std::string_view text) : LineReader(text) {}

    bool expect(std::string_view wanted) {
        const std::string_view w = word();
        return w == wanted ||
               fail("'" + std::string(wanted) + "' was to stand here, not " + core::quoted(w));
    }

    bool whole_number(const char* name, int least, int most, int& out) {
        const std::string_view w = word();
        const std::optional<int> value = core::parse_number<int>(w);
        if (!value || *value < least || *value > most) {
            return fail(std::string(name) + " is " + core::quoted(w) +
                        ", not a whole number from " + std::to_string(least) + " to " +
                        std::to_string(most));
        }
        out = *value;
        return true;
    }

    bool length(double& out) {
        const std::string_view w = word();
        const std::optional<double> value = core::parse_number<double>(w);
        if (!value || !(*value >= 0.0) || *value > kLongest) {
            return fail("the length is " + core::quoted(w) + ", not a number from 0 to 1e9");
        }
        out = *value;
        return true;
    }

    bool nothing_more() {
        const std::string_view w = word();
        return w.empty() || fail(core::quoted(w) + " is too much");
    }

    /// A line of one word and one number.
    bool setting(const char* name, int least, int most, int& out) {
        if (!next_written()) {
            return fail(std::string("the text ends where '") + name + "' was to stand");
        }
        return expect(name) && whole_number(name, least, most, out) && nothing_more();
    }

    bool heading(std::string_view first, std::string_view second) {
        if (!next_written()) {
            return fail("the text ends where '" + std::string(first) + "' was to stand");
        }
        return expect(first) && (second.empty() || expect(second)) && nothing_more();
    }
};

/// Whether a character of a map can be walked; nothing where there is no such character.
std::optional<bool> terrain(char c) {
    switch (c) {
        case '.':
        case 'G':
        case 'S':
            return true;
        case '@':
        case 'O':
        case 'T':
        case 'W':
            return false;
        default:
            return std::nullopt;
    }
}

/// The height and width and the rows below `map`; set(x, y, passable) is called for each cell.
template <class Begin, class Set>
bool read_rows(GridReader& in, const Begin& begin, const Set& set) {
    int width = 0;
    int height = 0;
    if (!in.setting("height", 1, GridMap::kMaxSide, height) ||
        !in.setting("width", 1, GridMap::kMaxSide, width) || !in.heading("map", "")) {
        return false;
    }
    begin(width, height);
    for (int y = 0; y < height; ++y) {
        if (!in.next()) {
            return in.fail("the text ends after " + std::to_string(y) + " of " +
                           std::to_string(height) + " rows");
        }
        const std::string_view row = in.rest();
        if (row.size() != static_cast<std::size_t>(width)) {
            return in.fail("a row of " + std::to_string(row.size()) + " characters, the width is " +
                           std::to_string(width));
        }
        for (int x = 0; x < width; ++x) {
            const std::optional<bool> passable = terrain(row[static_cast<std::size_t>(x)]);
            if (!passable) {
                return in.fail("column " + std::to_string(x + 1) +
                               ": no terrain has this character (. G S @ O T W have one)");
            }
            set(x, y, *passable);
        }
    }
    return true;
}

bool read_cell(GridReader& in,
               const char* x_name,
               const char* y_name,
               int width,
               int height,
               Cell& out) {
    int x = 0;
    int y = 0;
    if (!in.whole_number(x_name, 0, width - 1, x) || !in.whole_number(y_name, 0, height - 1, y)) {
        return false;
    }
    out = {static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)};
    return true;
}

bool read_instance(GridReader& in, int width, int height, GridInstance& out) {
    out.line = static_cast<int>(in.line());
    return read_cell(in, "start x", "start y", width, height, out.start) &&
           read_cell(in, "goal x", "goal y", width, height, out.goal) && in.length(out.length) &&
           in.nothing_more();
}

}  // namespace

core::Result<GridMap> parse_grid_map(std::string_view text) {
    using R = core::Result<GridMap>;
    GridReader in(text);
    std::optional<GridMap> map;
    const bool good =
        in.heading("type", "octile") &&
        read_rows(
            in,
            [&map](int width, int height) { map.emplace(width, height); },
            [&map](int x, int y, bool passable) {
                map->set_passable({static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)},
                                  passable);
            });
    if (good && in.next_written()) {
        in.fail("more text below the last row");
    }
    if (!in.failed() && map->passable_cells() > ai::pathfinding::kMostPassable) {
        in.fail(std::to_string(map->passable_cells()) + " passable cells, at most " +
                std::to_string(ai::pathfinding::kMostPassable) + " are allowed");
    }
    return in.failed() ? R::failure(in.error()) : R(std::move(*map));
}

core::Result<std::vector<GridInstance>> parse_grid_scenario(std::string_view text) {
    using R = core::Result<std::vector<GridInstance>>;
    GridReader in(text);
    std::vector<GridInstance> found;
    if (!in.next_written()) {
        return R::failure("line 1: the text is empty");
    }
    if (in.expect("version")) {
        const std::string_view version = in.word();
        if (version != "1" && version != "1.0") {
            in.fail("version " + core::quoted(version) + ", only 1 is known");
        }
    }
    while (!in.failed() && in.next_written()) {
        int bucket = 0;
        int width = 0;
        int height = 0;
        if (in.whole_number("bucket", 0, 1'000'000'000, bucket) && !in.word().empty() &&
            in.whole_number("width", 1, GridMap::kMaxSide, width) &&
            in.whole_number("height", 1, GridMap::kMaxSide, height)) {
            read_instance(in, width, height, found.emplace_back());
        }
    }
    return in.failed() ? R::failure(in.error()) : R(std::move(found));
}

core::Result<std::vector<GridPatch>> parse_grid_patches(std::string_view text) {
    using R = core::Result<std::vector<GridPatch>>;
    GridReader in(text);
    int count = 0;
    std::vector<GridPatch> patches;
    if (!in.heading("type", "patch") || !in.setting("patches", 0, kMostPatches, count)) {
        return R::failure(in.error());
    }
    for (int i = 0; i < count; ++i) {
        int number = 0;
        GridPatch patch;
        const bool good =
            in.setting("patch", i, i, number) &&
            read_rows(
                in,
                [&patch](int width, int height) {
                    patch.width = width;
                    patch.height = height;
                },
                [&patch](int, int, bool passable) { patch.passable.push_back(passable); });
        if (!good) {
            return R::failure(in.error());
        }
        patches.push_back(std::move(patch));
    }
    if (in.next_written()) {
        in.fail("more text below the last patch");
    }
    return in.failed() ? R::failure(in.error()) : R(std::move(patches));
}

core::Result<std::vector<GridEvent>> parse_grid_events(std::string_view text) {
    using R = core::Result<std::vector<GridEvent>>;
    GridReader in(text);
    int version = 0;
    int width = 0;
    int height = 0;
    if (!in.setting("version", 2, 2, version) ||
        !in.setting("height", 1, GridMap::kMaxSide, height) ||
        !in.setting("width", 1, GridMap::kMaxSide, width)) {
        return R::failure(in.error());
    }
    // The reader already knows the other header lines (costs, the file of patches).
    bool begun = false;
    while (!begun && in.next_written()) {
        begun = in.word() == "commands";
    }
    if (!begun) {
        in.fail("the text ends where 'commands' was to stand");
    }
    std::vector<GridEvent> events;
    while (!in.failed() && in.next_written()) {
        const std::string_view what = in.word();
        int bucket = 0;
        GridEvent& event = events.emplace_back();
        event.query = what == "Q";
        if (what != "Q" && what != "P") {
            in.fail("a command is Q or P");
        } else if (in.whole_number("bucket", 0, 1'000'000'000, bucket)) {
            if (event.query) {
                read_instance(in, width, height, event.instance);
            } else if (in.whole_number("patch", 0, kMostPatches, event.patch) &&
                       in.whole_number("x", 0, width - 1, event.x) &&
                       in.whole_number("y", 0, height - 1, event.y)) {
                in.nothing_more();
            }
        }
    }
    return in.failed() ? R::failure(in.error()) : R(std::move(events));
}

}  // namespace zoned::scenario

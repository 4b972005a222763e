#include "server/ai/pathfinding/hierarchy/region_next_hop.h"

#include "shared/core/assert.h"
#include "shared/core/state_hash.h"

#include <algorithm>
#include <cstdlib>

namespace zoned::ai::pathfinding {

namespace {

constexpr int kSmallestSide = 32;
/// Tables of regions grow with the square of their number.
constexpr int kMostSquares = 1024;
/// The largest stored distance of an exit, in cells; larger distances are cut to it.
constexpr std::uint32_t kFarthestExit = 4095;
constexpr std::uint16_t kNoPathThere = 65535;
/// Steps across a side, as Hop: to the right, left, down, up.
constexpr Hop kSides = 4;
constexpr std::uint32_t kAllSides = 15;
// The costs of renewal in units of about 2 ns.
constexpr std::uint64_t kSquareCellUnits = 5;  ///< a cell of a square whose regions are found
constexpr std::uint64_t kExitCellUnits = 7;    ///< a cell of the steps to an exit
constexpr std::uint64_t kJoinUnits = 5;        ///< an exit of the map, or a square

Cell area_cell(int x, int y) {
    return {static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)};
}

int side_for(const GridMap& map) {
    int side = kSmallestSide;
    const auto squares = [&map](int s) {
        return ((map.width() + s - 1) / s) * ((map.height() + s - 1) / s);
    };
    while (squares(side) > kMostSquares) {
        side *= 2;
    }
    return side;
}

}  // namespace

RegionNextHop::RegionNextHop(const GridMap& map, std::size_t most_tables)
    : most_tables_(most_tables),
      side_(side_for(map)),
      across_((map.width() + side_ - 1) / side_),
      down_((map.height() + side_ - 1) / side_),
      squares_(static_cast<std::size_t>(across_) * static_cast<std::size_t>(down_)),
      label_(map.places(), 0),
      stale_sides_(squares_.size(), 0) {
    for (std::uint32_t s = 0; s < squares_.size(); ++s) {
        find_regions(map, s);
    }
    for (std::uint32_t s = 0; s < squares_.size(); ++s) {
        find_exits(map, s, kAllSides);
    }
    join_regions_of_squares();
}

void RegionNextHop::note_square(std::uint32_t square, std::uint32_t sides) {
    if (stale_sides_[square] == 0) {
        stale_.push_back(square);
    }
    stale_sides_[square] = static_cast<std::uint8_t>(stale_sides_[square] | sides);
}

void RegionNextHop::note(std::span<const CellChange> changes) {
    for (const CellChange& c : changes) {
        note_square(square_of(c.cell), kAllSides);
    }
    forget_tables();
}

std::uint64_t RegionNextHop::settle(const GridMap& map) {
    if (stale_.empty()) {
        return 0;
    }
    units_ = 0;
    const std::size_t changed = stale_.size();
    for (std::size_t i = 0; i < changed; ++i) {
        // Exits of a square beside it are others only where the labels along their side are.
        const std::uint32_t square = stale_[i];
        const std::array<std::uint64_t, kSides> before = sides_of(map, square);
        find_regions(map, square);
        const std::array<std::uint64_t, kSides> after = sides_of(map, square);
        for (Hop side = 0; side < kSides; ++side) {
            const std::uint32_t other = beside(square, side);
            if (before[side] != after[side] && other != square) {
                note_square(other, 1U << (side ^ 1U));
            }
        }
    }
    units_ += kSquareCellUnits * changed * static_cast<std::uint64_t>(side_ * side_);
    for (const std::uint32_t square : stale_) {
        find_exits(map, square, stale_sides_[square]);
        stale_sides_[square] = 0;
    }
    stale_.clear();
    join_regions_of_squares();
    return units_ + kJoinUnits * (edges_.size() + squares_.size());
}

std::uint32_t RegionNextHop::beside(std::uint32_t square, Hop side) const {
    const int x = static_cast<int>(square) % across_ + (side == 0 ? 1 : side == 1 ? -1 : 0);
    const int y = static_cast<int>(square) / across_ + (side == 2 ? 1 : side == 3 ? -1 : 0);
    return x >= 0 && x < across_ && y >= 0 && y < down_
               ? static_cast<std::uint32_t>(y * across_ + x)
               : square;
}

std::array<std::uint64_t, 4> RegionNextHop::sides_of(const GridMap& map,
                                                     std::uint32_t square) const {
    const FlowField::Window w = window_of(map, square);
    std::array<core::StateHash, 4> hash;
    for (int y = w.top; y <= w.bottom; ++y) {
        hash[0].add(label_[map.place(area_cell(w.right, y))]);
        hash[1].add(label_[map.place(area_cell(w.left, y))]);
    }
    for (int x = w.left; x <= w.right; ++x) {
        hash[2].add(label_[map.place(area_cell(x, w.bottom))]);
        hash[3].add(label_[map.place(area_cell(x, w.top))]);
    }
    return {hash[0].value(), hash[1].value(), hash[2].value(), hash[3].value()};
}

FlowField::Window RegionNextHop::window_of(const GridMap& map, std::uint32_t square) const {
    const int left = static_cast<int>(square) % across_ * side_;
    const int top = static_cast<int>(square) / across_ * side_;
    return {left,
            top,
            std::min(left + side_, map.width()) - 1,
            std::min(top + side_, map.height()) - 1};
}

void RegionNextHop::find_regions(const GridMap& map, std::uint32_t square) {
    const FlowField::Window w = window_of(map, square);
    const bool open = is_open(map, w);
    for (int y = w.top; y <= w.bottom; ++y) {
        const Place row = map.place(area_cell(w.left, y));
        std::fill_n(
            label_.begin() + row, w.right - w.left + 1, open ? std::uint16_t{1} : std::uint16_t{0});
    }
    squares_[square].open = open;
    std::vector<RegionBox>& boxes = squares_[square].boxes;
    boxes.clear();
    if (open) {
        boxes.push_back(box_of(w));
        return;
    }
    for (int y = w.top; y <= w.bottom; ++y) {
        for (int x = w.left; x <= w.right; ++x) {
            const Cell c = area_cell(x, y);
            if (map.passable(map.place(c)) && label_[map.place(c)] == 0) {
                boxes.push_back(
                    fill_region(map, w, c, static_cast<std::uint16_t>(boxes.size() + 1)));
            }
        }
    }
}

bool RegionNextHop::is_open(const GridMap& map, const FlowField::Window& w) {
    for (int y = w.top; y <= w.bottom; ++y) {
        if (!map.all_passable(area_cell(w.left, y), w.right - w.left + 1)) {
            return false;
        }
    }
    return true;
}

/// All of a window, as fill_region() finds it.
RegionNextHop::RegionBox RegionNextHop::box_of(const FlowField::Window& w) {
    return {static_cast<std::uint16_t>(w.left),
            static_cast<std::uint16_t>(w.top),
            static_cast<std::uint16_t>(w.right - w.left + 1),
            static_cast<std::uint16_t>(w.bottom - w.top + 1),
            area_cell((w.left + w.right) / 2, (w.top + w.bottom) / 2),
            true};
}

RegionNextHop::RegionBox RegionNextHop::fill_region(const GridMap& map,
                                                    const FlowField::Window& w,
                                                    Cell first,
                                                    std::uint16_t label) {
    // Found cells stay in the list: the middle is looked for among them.
    stack_.assign(1, first);
    label_[map.place(first)] = label;
    int left = first.x;
    int right = first.x;
    int bottom = first.y;
    std::uint64_t sum_x = 0;
    std::uint64_t sum_y = 0;
    for (std::size_t i = 0; i < stack_.size(); ++i) {
        const Cell c = stack_[i];
        left = std::min<int>(left, c.x);
        right = std::max<int>(right, c.x);
        bottom = std::max<int>(bottom, c.y);
        sum_x += c.x;
        sum_y += c.y;
        for (Hop h = 0; h < kSides; ++h) {
            const Cell n = hopped(c, h);
            const bool within = n.x >= w.left && n.x <= w.right && n.y >= w.top && n.y <= w.bottom;
            if (within && map.passable(map.place(n)) && label_[map.place(n)] == 0) {
                label_[map.place(n)] = label;
                stack_.push_back(n);
            }
        }
    }
    const auto mean_x = static_cast<int>(sum_x / stack_.size());
    const auto mean_y = static_cast<int>(sum_y / stack_.size());
    const auto off = [&](Cell c) {
        return octile(c.x - mean_x, c.y - mean_y);
    };
    const Cell middle = *std::min_element(
        stack_.begin(), stack_.end(), [&off](Cell a, Cell b) { return off(a) < off(b); });
    return {static_cast<std::uint16_t>(left),
            first.y,
            static_cast<std::uint16_t>(right - left + 1),
            static_cast<std::uint16_t>(bottom - first.y + 1),
            middle,
            stack_.size() == static_cast<std::size_t>(right - left + 1) *
                                 static_cast<std::size_t>(bottom - first.y + 1)};
}

void RegionNextHop::find_exits(const GridMap& map, std::uint32_t square, std::uint32_t sides) {
    Square& s = squares_[square];
    std::swap(old_.exits, s.exits);
    std::swap(old_.steps, s.steps);
    std::swap(old_.first_exit, s.first_exit);
    s.exits.clear();
    s.steps.clear();
    s.first_exit.clear();
    for (std::uint16_t region = 0; region < s.boxes.size(); ++region) {
        s.first_exit.push_back(static_cast<std::uint32_t>(s.exits.size()));
        for (Hop side = 0; side < kSides; ++side) {
            if ((sides >> side & 1U) != 0) {
                add_exits(map, square, region, side);
            } else {
                keep_exits(square, region, beside(square, side));
            }
        }
    }
    s.first_exit.push_back(static_cast<std::uint32_t>(s.exits.size()));
}

/// Keeps the exits of `old_` that lead to another square.
void RegionNextHop::keep_exits(std::uint32_t square, std::uint16_t region, std::uint32_t beyond) {
    Square& s = squares_[square];
    const std::uint32_t steps = std::uint32_t{s.boxes[region].width} * s.boxes[region].height;
    for (std::uint32_t e = old_.first_exit[region]; e < old_.first_exit[region + 1U]; ++e) {
        const Exit& exit = old_.exits[e];
        if (exit.square == beyond) {
            s.exits.push_back(exit);
            if (exit.open) {
                continue;
            }
            s.exits.back().first = static_cast<std::uint32_t>(s.steps.size());
            const auto first = old_.steps.begin() + exit.first;
            s.steps.insert(s.steps.end(), first, first + steps);
        }
    }
}

void RegionNextHop::add_exits(const GridMap& map,
                              std::uint32_t square,
                              std::uint16_t region,
                              Hop side) {
    const std::uint32_t other_square = beside(square, side);
    if (squares_[square].open && squares_[other_square].open && other_square != square) {
        add_exit(map, square, {0, 0, other_square, 0, true, 0}, side);
        return;
    }
    const FlowField::Window w = window_of(map, square);
    const bool upright = side < 2;
    const int line = side == 0 ? w.right : side == 1 ? w.left : side == 2 ? w.bottom : w.top;
    const int begin = upright ? w.top : w.left;
    const int end = upright ? w.bottom : w.right;
    touched_.clear();
    for (int i = begin; i <= end; ++i) {
        const Cell c = upright ? area_cell(line, i) : area_cell(i, line);
        const Cell beyond = hopped(c, side);  // wraps beside the map, where nothing is passable
        if (label_[map.place(c)] == region + 1 && map.passable(beyond)) {
            touched_.push_back({static_cast<std::uint16_t>(label_[map.place(beyond)] - 1), c});
        }
    }
    std::sort(touched_.begin(), touched_.end(), [](const auto& a, const auto& b) {
        return a.other != b.other ? a.other < b.other : a.cell.x + a.cell.y < b.cell.x + b.cell.y;
    });
    for (std::size_t i = 0; i < touched_.size();) {
        const std::uint16_t other = touched_[i].other;
        crossings_.clear();
        for (; i < touched_.size() && touched_[i].other == other; ++i) {
            crossings_.push_back(touched_[i].cell);
        }
        const std::uint32_t beyond = square_of(hopped(crossings_.front(), side));
        const RegionBox& box = squares_[square].boxes[region];
        const bool open = box.whole && crossings_.size() == (upright ? box.height : box.width);
        add_exit(map, square, {region, other, beyond, 0, open, 0}, side);
    }
}

void RegionNextHop::add_exit(const GridMap& map,
                             std::uint32_t square,
                             const Exit& exit,
                             Hop across) {
    Square& s = squares_[square];
    const RegionBox& box = s.boxes[exit.region];
    s.exits.push_back(exit);
    Exit& added = s.exits.back();
    units_ += kExitCellUnits * static_cast<std::uint64_t>(box.width * box.height);
    if (added.open) {
        added.first = open_exit(map, box, across);
    } else {
        added.first = static_cast<std::uint32_t>(s.steps.size());
        append_steps(map, box, exit.region, across, s.steps);
    }
    added.cells = std::uint32_t{step(s, added, box.middle)} >> kHopBits;
}

/// The first of the steps of an exit along a whole side of an open box.
std::uint32_t RegionNextHop::open_exit(const GridMap& map, const RegionBox& box, Hop across) {
    for (const OpenExit& known : open_exits_) {
        if (known.width == box.width && known.height == box.height && known.side == across) {
            return known.first;
        }
    }
    const auto first = static_cast<std::uint32_t>(open_steps_.size());
    open_exits_.push_back({box.width, box.height, across, first});
    const bool upright = across < 2;
    const int line = across == 0   ? box.left + box.width - 1
                     : across == 1 ? box.left
                     : across == 2 ? box.top + box.height - 1
                                   : box.top;
    crossings_.clear();
    for (int i = 0; i < (upright ? box.height : box.width); ++i) {
        crossings_.push_back(upright ? area_cell(line, box.top + i)
                                     : area_cell(box.left + i, line));
    }
    append_steps(map,
                 box,
                 static_cast<std::uint16_t>(label_[map.place(box.middle)] - 1),
                 across,
                 open_steps_);
    return first;
}

void RegionNextHop::append_steps(const GridMap& map,
                                 const RegionBox& box,
                                 std::uint16_t region,
                                 Hop across,
                                 std::vector<Step>& steps) {
    // Nothing of the region lies beyond its box.
    field_.build(
        map, crossings_, {box.left, box.top, box.left + box.width - 1, box.top + box.height - 1});
    for (int y = box.top; y < box.top + box.height; ++y) {
        for (int x = box.left; x < box.left + box.width; ++x) {
            const Place p = map.place(area_cell(x, y));
            if (label_[p] != region + 1) {
                steps.push_back(kNoHop);
                continue;
            }
            // Rounded up: each step is still nearer by a cell at least.
            const std::uint32_t cells =
                std::min((field_.cost(p) + kStraight - 1) / kStraight, kFarthestExit);
            const Hop hop = field_.hop(p) == kArrived ? across : field_.hop(p);
            steps.push_back(static_cast<Step>(cells << kHopBits | hop));
        }
    }
}

void RegionNextHop::join_regions_of_squares() {
    first_region_.assign(1, 0);
    for (const Square& s : squares_) {
        first_region_.push_back(first_region_.back() + static_cast<std::uint32_t>(s.boxes.size()));
    }
    first_edge_.assign(1, 0);
    edges_.clear();
    for (std::uint32_t square = 0; square < squares_.size(); ++square) {
        const Square& s = squares_[square];
        for (std::uint32_t region = 0; region < s.boxes.size(); ++region) {
            for (std::uint32_t e = s.first_exit[region]; e < s.first_exit[region + 1]; ++e) {
                const Exit& exit = s.exits[e];
                const Square& beyond = squares_[exit.square];
                // The exit back, so that it is as far there as back.
                const auto begin = beyond.exits.begin() + beyond.first_exit[exit.other];
                const auto back = std::find_if(begin, beyond.exits.end(), [&](const Exit& b) {
                    return b.square == square && b.other == exit.region;
                });
                edges_.push_back(
                    {first_region_[exit.square] + exit.other, exit.cells + 1 + back->cells});
            }
            first_edge_.push_back(static_cast<std::uint32_t>(edges_.size()));
        }
    }
    open_.resize(first_region_.back());
    cells_to_.assign(first_region_.back(), ~0U);
    forget_tables();
}

bool RegionNextHop::prepare(const GridMap& map, Cell to, const TableUse& use) {
    ZONED_ASSERT(settled() && map.passable(to), "a goal that is blocked, or what is not settled");
    const std::uint32_t goal = region_of(map, to);
    if (table_of_[goal] == kNoTable) {
        make_table(goal, use);
        return true;
    }
    tables_[table_of_[goal]].used = use.now;
    return false;
}

void RegionNextHop::prepare_next(std::uint64_t now) {
    const auto first = std::find(table_of_.begin(), table_of_.end(), kNoTable);
    make_table(static_cast<std::uint32_t>(first - table_of_.begin()), {now, 0});
}

void RegionNextHop::make_table(std::uint32_t goal, const TableUse& use) {
    table_of_[goal] = free_table(use.needed_since);
    tables_[table_of_[goal]].goal = goal;
    tables_[table_of_[goal]].used = use.now;
    measure(goal);
}

std::uint32_t RegionNextHop::free_table(std::uint64_t needed_since) {
    if (used_tables_ >= most_tables_) {
        const auto oldest =
            std::min_element(tables_.begin(),
                             tables_.begin() + static_cast<std::ptrdiff_t>(used_tables_),
                             [](const Table& a, const Table& b) {
                                 return a.used != b.used ? a.used < b.used : a.goal < b.goal;
                             });
        if (oldest->used < needed_since) {
            table_of_[oldest->goal] = kNoTable;
            return static_cast<std::uint32_t>(oldest - tables_.begin());
        }
    }
    if (used_tables_ == tables_.size()) {
        tables_.emplace_back();
    }
    return static_cast<std::uint32_t>(used_tables_++);
}

void RegionNextHop::measure(std::uint32_t goal) {
    std::fill(cells_to_.begin(), cells_to_.end(), ~0U);
    cells_to_[goal] = 0;
    open_.push(goal, 0);
    while (!open_.empty()) {
        const std::uint32_t at = open_.pop();
        for (std::uint32_t e = first_edge_[at]; e < first_edge_[at + 1]; ++e) {
            const std::uint32_t sum = cells_to_[at] + edges_[e].cells;
            if (sum < cells_to_[edges_[e].to]) {
                cells_to_[edges_[e].to] = sum;
                open_.push(edges_[e].to, sum);
            }
        }
    }
    std::vector<std::uint16_t>& row = tables_[table_of_[goal]].far;
    row.clear();
    row.reserve(cells_to_.size());
    for (const std::uint32_t c : cells_to_) {
        row.push_back(static_cast<std::uint16_t>(std::min<std::uint32_t>(c, kNoPathThere)));
    }
}

const RegionNextHop::Exit* RegionNextHop::best_exit(const Square& square,
                                                    std::uint32_t region,
                                                    std::uint32_t goal,
                                                    Cell from) const {
    ZONED_ASSERT(table_of_[goal] != kNoTable, "a goal that is not prepared");
    const std::uint16_t* const far = tables_[table_of_[goal]].far.data();
    const std::uint32_t local =
        region - first_region_[static_cast<std::size_t>(&square - squares_.data())];
    std::uint32_t least = ~0U;
    const Exit* best = nullptr;
    for (std::uint32_t e = square.first_exit[local]; e < square.first_exit[local + 1]; ++e) {
        const Exit& exit = square.exits[e];
        const std::uint32_t beyond = far[first_region_[exit.square] + exit.other];
        // Only on to regions that are nearer: so hops never lead round and round.
        if (beyond < far[region]) {
            const std::uint32_t cells =
                beyond + (std::uint32_t{step(square, exit, from)} >> kHopBits);
            if (cells < least) {
                least = cells;
                best = &exit;
            }
        }
    }
    return best;
}

void RegionNextHop::forget_tables() {
    used_tables_ = 0;
    table_of_.assign(first_region_.back(), kNoTable);
}

Hop RegionNextHop::hop(const GridMap& map, Cell from, Cell to) const {
    const std::uint32_t region = region_of(map, from);
    const std::uint32_t goal = region_of(map, to);
    if (region == goal) {
        return kArrived;
    }
    const Square& square = squares_[square_of(from)];
    const Exit* const exit = best_exit(square, region, goal, from);
    return exit == nullptr ? kNoHop : static_cast<Hop>(step(square, *exit, from) & kHopMask);
}

std::uint32_t RegionNextHop::cells(const GridMap& map, Cell from, Cell to) const {
    const std::uint32_t region = region_of(map, from);
    const std::uint32_t goal = region_of(map, to);
    if (region == goal) {
        return octile(from.x - to.x, from.y - to.y) / kStraight;
    }
    const Square& square = squares_[square_of(from)];
    const Exit* const exit = best_exit(square, region, goal, from);
    if (exit == nullptr) {
        return kNoPathThere;
    }
    const Cell middle = squares_[square_of(to)].boxes[label_[map.place(to)] - 1U].middle;
    return (std::uint32_t{step(square, *exit, from)} >> kHopBits) + 1 +
           tables_[table_of_[goal]].far[first_region_[exit->square] + exit->other] +
           octile(middle.x - to.x, middle.y - to.y) / kStraight;
}

std::size_t RegionNextHop::bytes() const {
    std::size_t bytes = label_.capacity() * sizeof(std::uint16_t) +
                        edges_.capacity() * sizeof(RegionEdge) + field_.bytes();
    for (const Square& s : squares_) {
        bytes += sizeof(Square) + s.boxes.capacity() * sizeof(RegionBox) +
                 s.exits.capacity() * sizeof(Exit) + s.steps.capacity() * sizeof(Step);
    }
    for (const Table& table : tables_) {
        bytes += sizeof(Table) + table.far.capacity() * sizeof(std::uint16_t);
    }
    bytes += open_steps_.capacity() * sizeof(Step) + table_of_.capacity() * sizeof(std::uint32_t);
    return bytes;
}

}  // namespace zoned::ai::pathfinding

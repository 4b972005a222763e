#include "server/ai/agent/offscreen_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace zoned::ai {

namespace {

/// A walker that brakes or turns is checked when that is over, or after this many ticks.
constexpr float kBent = 8.0F;
/// A walker at the end of its segment has an event in the next tick. Squares reach this many steps
/// further.
constexpr float kStepsBeyond = 3.0F;

/// Takes cells, not metres. For far places and NaN any line will do.
std::int32_t line_of(float coordinate) {
    const float line = std::floor(coordinate / OffscreenGrid::kCell_m);
    return std::abs(line) < 1e9F ? static_cast<std::int32_t>(line) : 0;
}

/// The distance along `direction` from `from` to where it leaves [low, high], which lies ahead, m.
float straight_exit(float from, float direction, float low, float high) {
    if (direction == 0.0F) {
        return std::numeric_limits<float>::infinity();
    }
    return ((direction > 0.0F ? high : low) - from) / direction;
}

/// The control points of the turn at the beginning of a segment. The turn is a parabola, a Bezier
/// curve of second order.
struct Turn {
    explicit Turn(const PathSegment& segment)
        : start(segment.from + segment.bend * (segment.bend_s * segment.bend_s)),
          end(segment.from + segment.direction * (segment.speed * segment.bend_s)),
          control(0.5F * (segment.from + end)) {}

    Vec2 start;
    Vec2 end;
    Vec2 control;
};

/// Whether the turn leads beyond the first piece.
bool turns_far(const PathSegment& segment) {
    const float start_m = (segment.bend * (segment.bend_s * segment.bend_s)).dot(segment.direction);
    return !(std::max(start_m, segment.speed * segment.bend_s) < OffscreenGrid::kPiece_m);
}

/// A piece of the walk at full speed, between these distances along the segment, m.
struct Piece {
    float begin_m = 0.0F;
    float end_m = 0.0F;
};

/// The piece that contains `at`; the whole walk if its turn leads beyond the first piece.
Piece piece_at(const PathSegment& segment, const Vec2& at) {
    constexpr float kMostPieces = 1e6F;
    if (turns_far(segment)) {
        return {0.0F, std::numeric_limits<float>::infinity()};
    }
    const float way = (at - segment.from).dot(segment.direction);
    const float number = std::floor(way / OffscreenGrid::kPiece_m);
    const float begin_m = std::clamp(number, 0.0F, kMostPieces) * OffscreenGrid::kPiece_m;
    return {begin_m, begin_m + OffscreenGrid::kPiece_m};
}

std::uint32_t cell_of(std::int32_t x, std::int32_t z, std::uint32_t side) {
    return static_cast<std::uint32_t>(z) % side * side + static_cast<std::uint32_t>(x) % side;
}

}  // namespace

/// Collects squares, each once, as long as there are few.
class OffscreenGrid::Squares {
  public:
    [[nodiscard]] std::span<const Cell> found() const { return {cells_.data(), count_}; }

    /// There are too many squares, or they are not known.
    void add_anywhere() {
        many_ = true;
        cells_[0] = kAnywhere;
        count_ = 1;
    }

    /// Adds all squares that a straight walk touches.
    void add_path(const Vec2& a, const Vec2& b) {
        const Vec2 low = a.cwiseMin(b);
        const Vec2 high = a.cwiseMax(b);
        const std::int32_t first = line_of(low.y());
        const std::int32_t last = line_of(high.y());
        const std::int32_t column = line_of(low.x());
        if (first == last && column == line_of(high.x())) {
            add(cell_of(column, first, kSide));  // most walks
            return;
        }
        for (std::int32_t z = first; z <= last && !many_; ++z) {
            // The part of the walk within this row of squares.
            float first_x = a.x();
            float last_x = b.x();
            if (a.y() != b.y()) {
                const float per_m = (b.x() - a.x()) / (b.y() - a.y());
                const float top = static_cast<float>(z) * kCell_m;
                first_x = a.x() + (std::max(top, low.y()) - a.y()) * per_m;
                last_x = a.x() + (std::min(top + kCell_m, high.y()) - a.y()) * per_m;
            }
            add_row(z, std::min(first_x, last_x), std::max(first_x, last_x));
        }
    }

    /// Adds all squares that a box touches.
    void add_box(const Vec2& low, const Vec2& high) {
        const std::int32_t last = line_of(high.y());
        for (std::int32_t z = line_of(low.y()); z <= last && !many_; ++z) {
            add_row(z, low.x(), high.x());
        }
    }

  private:
    void add_row(std::int32_t z, float low_x, float high_x) {
        const std::int32_t last = line_of(high_x);
        for (std::int32_t x = line_of(low_x); x <= last && !many_; ++x) {
            add(cell_of(x, z, kSide));
        }
    }

    void add(Cell cell) {
        if (std::find(cells_.begin(), cells_.begin() + count_, cell) != cells_.begin() + count_) {
            return;
        }
        if (count_ == kMost) {
            add_anywhere();
            return;
        }
        cells_[count_++] = cell;
    }

    std::array<Cell, kMost> cells_{};
    std::uint32_t count_ = 0;
    bool many_ = false;
};

OffscreenGrid::Cell OffscreenGrid::cell_at(const Vec2& at) {
    return cell_of(line_of(at.x()), line_of(at.y()), kSide);
}

Tick OffscreenGrid::left_at(const PathSegment& segment,
                            const Vec2& at,
                            const Vec2& half_size,
                            float dt,
                            bool goes_on) {
    const float step_m = segment.speed * dt;
    const bool steps_within =
        !goes_on && segment.length == 0.0F &&
        ((segment.goal.array().abs() + kStepsBeyond * step_m) < half_size.array()).all();
    if (!(step_m > 0.0F) || steps_within) {
        return kNever;
    }
    float way = piece_at(segment, at).end_m;
    for (int axis = 0; axis < 2; ++axis) {
        if (std::abs(at[axis]) <= half_size[axis]) {
            way = std::min(way,
                           straight_exit(segment.from[axis],
                                         segment.direction[axis],
                                         -half_size[axis],
                                         half_size[axis]));
        }
    }
    const float bent = std::ceil(segment.bend_s / dt);
    const float ticks = std::max(std::ceil(way / step_m), std::min(bent, kBent));
    // Written so that NaN is late.
    return segment.since + 1 + static_cast<Tick>(ticks < 1e9F ? std::max(0.0F, ticks) : 1e9F);
}

void OffscreenGrid::grow(std::size_t slots) {
    if (slots > puts_.size()) {
        puts_.resize(slots);
        nodes_.resize(slots * kMost);
        if (heads_.empty() && slots > 0) {
            heads_.assign(kSide * kSide + 1, kNone);
        }
    }
}

/// A turn lies within the box of its control points. Its distance from its chord is at most an
/// eighth of the change of velocity times its duration.
void OffscreenGrid::put(Slot slot,
                        const PathSegment& segment,
                        const Vec2& at,
                        float dt,
                        bool goes_on) {
    Piece piece = piece_at(segment, at);
    const float step_m = segment.speed * dt;
    if (!goes_on) {
        // A segment without a length is a step with a herd, to its goal.
        const float length =
            segment.length > 0.0F ? segment.length : (segment.goal - segment.from).norm();
        piece.end_m = std::clamp(length + kStepsBeyond * step_m, piece.begin_m, piece.end_m);
    }
    const Put put{segment.since, segment.from, segment.direction, piece.begin_m, piece.end_m};
    if (puts_[slot].squares > 0 && puts_[slot].same_as(put)) {
        return;
    }
    Squares squares;
    Vec2 begin = segment.from + segment.direction * piece.begin_m;
    if (piece.begin_m == 0.0F && segment.bend_s > 0.0F) {
        const Turn turn(segment);
        if (0.25F * (turn.start - segment.from).norm() > kAside_m) {
            squares.add_box(turn.start.cwiseMin(turn.control).cwiseMin(turn.end),
                            turn.start.cwiseMax(turn.control).cwiseMax(turn.end));
        } else {
            squares.add_path(turn.start, turn.end);
        }
        begin = turn.end;
    }
    squares.add_path(begin,
                     step_m > 0.0F ? Vec2(segment.from + segment.direction * piece.end_m) : begin);
    if (turns_far(segment) || squares.found().empty()) {
        squares.add_anywhere();
    }
    // Many agents go to and fro in one square. Prefetch its list, which lies scattered in memory.
    const std::span<const GridNode> nodes(&nodes_[std::size_t{slot} * kMost], puts_[slot].squares);
    const std::span<const Cell> found = squares.found();
    if (!std::equal(
            found.begin(), found.end(), nodes.begin(), nodes.end(), [](Cell c, const GridNode& n) {
                return n.cell == c;
            })) {
        take(slot);
        link(slot, squares);
    }
    puts_[slot] = put;
    puts_[slot].squares = static_cast<std::uint32_t>(found.size());
}

void OffscreenGrid::link(Slot slot, const Squares& squares) {
    const std::span<const Cell> found = squares.found();
    Index at = slot * kMost;
    for (const Cell cell : found) {
        nodes_[at] = {cell, heads_[cell], kNone};
        if (heads_[cell] != kNone) {
            nodes_[heads_[cell]].previous = at;
        }
        heads_[cell] = at++;
    }
}

void OffscreenGrid::take(Slot slot) {
    const Index first = slot * kMost;
    for (Index at = first; at < first + puts_[slot].squares; ++at) {
        const GridNode& node = nodes_[at];
        if (node.next != kNone) {
            nodes_[node.next].previous = node.previous;
        }
        (node.previous != kNone ? nodes_[node.previous].next : heads_[node.cell]) = node.next;
    }
    puts_[slot].squares = 0;
}

void OffscreenGrid::within(std::span<const Vec2> places, float radius_m, std::vector<Cell>& out) {
    out.clear();
    for (const Vec2& place : places) {
        const float reach = std::min(radius_m, 0.5F * kCell_m * static_cast<float>(kSide));
        const std::int32_t x1 = line_of(place.x() + reach);
        const std::int32_t z1 = line_of(place.y() + reach);
        for (std::int32_t z = line_of(place.y() - reach); z <= z1; ++z) {
            for (std::int32_t x = line_of(place.x() - reach); x <= x1; ++x) {
                const Vec2 low(static_cast<float>(x) * kCell_m, static_cast<float>(z) * kCell_m);
                const Vec2 nearest = place.cwiseMax(low).cwiseMin((low.array() + kCell_m).matrix());
                if ((nearest - place).squaredNorm() <= radius_m * radius_m) {
                    out.push_back(cell_of(x, z, kSide));
                }
            }
        }
    }
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
}

}  // namespace zoned::ai

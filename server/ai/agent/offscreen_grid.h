// OffscreenGrid: the squares of the plane that each suspended agent walks through. A look-up of a
// place finds the agents that may be there.
#pragma once

#include "server/ai/agent/agent.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai {

/// Squares repeat after kSide of them in x and z, so the plane needs no bounds. An agent found by
/// its square may therefore be elsewhere: check its position. An agent is in all squares that its
/// walk leads through, so nothing happens when it crosses from one to the next. Walks through too
/// many squares are cut into pieces. Squares are lists through the slots: only new slots allocate
/// memory. It has its own grid beside spatial::PointGrid, which holds points: a walk fills several
/// squares, and is put anew only when it ends.
class OffscreenGrid {
  public:
    using Slot = std::uint32_t;
    using Cell = std::uint32_t;

    static constexpr float kCell_m = 64.0F;
    /// Walks are cut into pieces of this length, m.
    static constexpr float kPiece_m = 256.0F;

    /// The square of a place (x, z, m); some square for NaN.
    [[nodiscard]] static Cell cell_at(const Vec2& at);

    /// The tick at which a walker along `segment` ends the piece that contains `at` (x, z, m), a
    /// place on the segment. Or the tick at which it leaves `half_size` (x, z, m) around the
    /// origin, if `at` is within.
    ///
    /// At the end of the tick before the one returned the walker is outside, or a rounding error
    /// before that. A walker that brakes or turns may have been outside for some ticks. All places
    /// of the same piece give the same answer. The answer is kNever for an agent that stands, and
    /// for a herd step to a place within, unless it `goes_on` from there.
    [[nodiscard]] static Tick left_at(const PathSegment& segment,
                                      const Vec2& at,
                                      const Vec2& half_size,
                                      float dt,
                                      bool goes_on = false);

    /// Makes the slots below `slots` exist; new ones are in no square.
    void grow(std::size_t slots);

    /// The greatest distance of a walk from its squares because a turn is not straight, m.
    static constexpr float kAside_m = 2.0F;

    /// Moves an agent into all squares that its walk along `segment` leads through, on the piece
    /// that contains `at`. Until left_at() the walker is at most kAside_m outside of them. With
    /// `goes_on` this holds also if it walks on from the end of its segment for more than a tick.
    /// An agent whose piece leads through too many squares may be anywhere. `dt` in s. All places
    /// of the same piece give the same result.
    void put(Slot slot, const PathSegment& segment, const Vec2& at, float dt, bool goes_on = false);
    void take(Slot slot);

    /// Prefetches the data that put() and take() read of the slot.
    void prefetch(Slot slot) const {
        const GridNode* const nodes = &nodes_[std::size_t{slot} * kMost];
        __builtin_prefetch(&puts_[slot], 1);
        __builtin_prefetch(nodes, 1);
        __builtin_prefetch(nodes + kMost / 2, 1);
    }

    /// Prefetches the slots beside this one in the lists of its squares. Prefetch the slot itself
    /// earlier.
    void prefetch_neighbours(Slot slot) const {
        const Index first = slot * kMost;
        for (Index at = first; at < first + puts_[slot].squares; ++at) {
            prefetch_node(nodes_[at].next);
            prefetch_node(nodes_[at].previous);
        }
    }

    /// Calls visit(slot) for all agents that walk through a square, in no order. `visit` must
    /// change no square.
    template <class Visit>
    void visit(Cell cell, Visit&& visit) const {
        for (Index n = heads_.empty() ? kNone : heads_[cell]; n != kNone; n = nodes_[n].next) {
            visit(n / kMost);
        }
    }

    /// Does the same for agents that may be anywhere.
    template <class Visit>
    void visit_anywhere(Visit&& visit_slot) const {
        visit(kAnywhere, visit_slot);
    }

    /// Replaces `out` by the squares within `radius_m` of any of the places (x, z, m), each once,
    /// ascending.
    static void within(std::span<const Vec2> places, float radius_m, std::vector<Cell>& out);

  private:
    static constexpr std::uint32_t kSide = 128;  ///< a power of two
    static constexpr std::uint32_t kNone = 0xFFFFFFFFU;
    static constexpr Cell kAnywhere = kSide * kSide;
    /// Squares of a piece: 256 m sqrt(2) / 64 m + 2 for the walk, and some for the turn before it.
    static constexpr std::uint32_t kMost = 12;

    /// slot * kMost + the number of the square among its squares.
    using Index = std::uint32_t;

    struct GridNode {
        Cell cell = kNone;
        Index next = kNone;
        Index previous = kNone;
    };

    /// The arguments of the last put() of a slot.
    struct Put {
        Tick since = 0;
        Vec2 from = Vec2::Zero();
        Vec2 direction = Vec2::Zero();
        float begin_m = 0.0F;
        float end_m = 0.0F;
        std::uint32_t squares = 0;  ///< 0: in no square

        [[nodiscard]] bool same_as(const Put& other) const {
            return since == other.since && from == other.from && direction == other.direction &&
                   begin_m == other.begin_m && end_m == other.end_m;
        }
    };

    class Squares;

    void prefetch_node(Index at) const {
        if (at != kNone) {
            __builtin_prefetch(&nodes_[at], 1);
        }
    }

    void link(Slot slot, const Squares& squares);

    std::vector<Put> puts_;        // by slot
    std::vector<GridNode> nodes_;  // kMost by slot
    std::vector<Index> heads_;     // by square; made with the first slot
};

}  // namespace zoned::ai

// OffscreenGrid: which squares of the plane each suspended agent comes through, so that a look at a
// place finds those who may be there.
#pragma once

#include "server/ai/agent/agent.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai {

/// Squares that repeat after kSide of them in x and z, so that the plane needs no bounds: who is
/// asked for by square has to be asked where it is. Who walks is in all squares that its way leads
/// through, so that nothing needs to be done when it goes from one to the next; paths are cut where
/// they would lead through too many. Squares are lists through the slots: nothing is allocated but
/// where slots are new.
class OffscreenGrid {
  public:
    using Slot = std::uint32_t;
    using Cell = std::uint32_t;

    static constexpr float kCell_m = 64.0F;
    /// Walks are cut into pieces of so much, m.
    static constexpr float kPiece_m = 256.0F;

    /// The square that a place (x, z, m) lies in; of what is no number, some square.
    [[nodiscard]] static Cell cell_at(const Vec2& at);

    /// When who walks along `segment` has come to the end of the piece of it that `at` (x, z, m), a
    /// place on it, lies in, or leaves `half_size` (x, z, m) around the origin where `at` is
    /// within: at the end of the tick before the one returned it is outside, or may be a rounding
    /// before that; who brakes or turns may have been outside for some ticks. The same whenever it
    /// is asked with a place of the same piece. kNever for who stands, and for who steps with a
    /// herd to a place within, unless it `goes_on` from there.
    [[nodiscard]] static Tick left_at(const PathSegment& segment,
                                      const Vec2& at,
                                      const Vec2& half_size,
                                      float dt,
                                      bool goes_on = false);

    /// Slots below `slots` exist, new ones nowhere.
    void grow(std::size_t slots);

    /// What of a walk may be outside of its squares because a turn is not straight, m.
    static constexpr float kAside_m = 2.0F;

    /// From wherever it was into all squares that a walk along `segment` comes through on the piece
    /// of it that `at` lies in: until left_at() the walker is at most kAside_m outside of them,
    /// unless it walks on from the end of its segment for more than a tick; then it `goes_on`.
    /// Whose piece leads through too many squares may be anywhere. `dt` in s. The same whenever it
    /// is asked with a place of the same piece.
    void put(Slot slot, const PathSegment& segment, const Vec2& at, float dt, bool goes_on = false);
    void take(Slot slot);

    /// Asks for what put() and take() read of the slot soon.
    void prefetch(Slot slot) const {
        const GridNode* const nodes = &nodes_[std::size_t{slot} * kMost];
        __builtin_prefetch(&puts_[slot], 1);
        __builtin_prefetch(nodes, 1);
        __builtin_prefetch(nodes + kMost / 2, 1);
    }

    /// Asks for the slots that stand beside it in the lists of its squares; once it was asked for
    /// itself.
    void prefetch_neighbours(Slot slot) const {
        const Index first = slot * kMost;
        for (Index at = first; at < first + puts_[slot].squares; ++at) {
            prefetch_node(nodes_[at].next);
            prefetch_node(nodes_[at].previous);
        }
    }

    /// Calls visit(slot) for all that come through a square, in no order; it must change no square.
    template <class Visit>
    void visit(Cell cell, Visit&& visit) const {
        for (Index n = heads_[cell]; n != kNone; n = nodes_[n].next) {
            visit(n / kMost);
        }
    }

    /// The same for those who may be anywhere.
    template <class Visit>
    void visit_anywhere(Visit&& visit_slot) const {
        visit(kAnywhere, visit_slot);
    }

    /// Replaces `out` by the squares that come within `radius_m` of a place (x, z, m), each once,
    /// ascending.
    static void within(std::span<const Vec2> places, float radius_m, std::vector<Cell>& out);

  private:
    static constexpr std::uint32_t kSide = 128;  ///< a power of two
    static constexpr std::uint32_t kNone = 0xFFFFFFFFU;
    static constexpr Cell kAnywhere = kSide * kSide;
    /// Squares of a piece: 256 m sqrt(2) / 64 m + 2 of the walk, and some for the turn before it.
    static constexpr std::uint32_t kMost = 12;

    /// Of slot * kMost + the how many-th of its squares.
    using Index = std::uint32_t;

    struct GridNode {
        Cell cell = kNone;
        Index next = kNone;
        Index previous = kNone;
    };

    /// What a slot was put for.
    struct Put {
        Tick since = 0;
        Vec2 from = Vec2::Zero();
        Vec2 direction = Vec2::Zero();
        float begin_m = 0.0F;
        float end_m = 0.0F;
        std::uint32_t squares = 0;  ///< 0: nowhere

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
    std::vector<Index> heads_ = std::vector<Index>(kSide * kSide + 1, kNone);
};

}  // namespace zoned::ai

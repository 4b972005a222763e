// CoarseCells: in which square of the plane each coarse mind is, so that a look at a place finds
// those who are there.
#pragma once

#include "server/ai/mind.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai {

/// Squares that repeat after kSide of them in x and z, so that the plane needs no bounds: who is
/// asked for by square has to be asked where it is. Squares are lists through the slots: nothing is
/// allocated but where slots are new.
class CoarseCells {
  public:
    using Slot = std::uint32_t;
    using Cell = std::uint32_t;

    static constexpr float kCell_m = 64.0F;

    /// The square that a place (x, z, m) lies in; of what is no number, some square.
    [[nodiscard]] static Cell cell_at(const Vec2& at);

    /// When who walks along `leg` leaves the square of `at`, a place on it, or `half_size` (x, z,
    /// m) around the origin where `at` is within: at the end of the tick before the one returned it
    /// is outside, or may be a rounding before that; who brakes or turns may have been outside for
    /// some ticks. The same whenever it is asked. kNever for who stands.
    [[nodiscard]] static Tick left_at(const Leg& leg,
                                      const Vec2& at,
                                      const Vec2& half_size,
                                      float dt);

    /// Slots below `slots` exist, new ones nowhere.
    void grow(std::size_t slots);

    /// From wherever it was.
    void put(Slot slot, Cell cell);
    void take(Slot slot);

    void prefetch(Slot slot) const { __builtin_prefetch(&nodes_[slot], 1); }

    /// Calls visit(slot) for all in a square, in no order; it must change no square.
    template <class Visit>
    void visit(Cell cell, Visit&& visit) const {
        for (Slot slot = heads_[cell]; slot != kNone; slot = nodes_[slot].next) {
            visit(slot);
        }
    }

    /// Replaces `out` by the squares that come within `radius_m` of a place (x, z, m), each once,
    /// ascending.
    static void within(std::span<const Vec2> places, float radius_m, std::vector<Cell>& out);

  private:
    static constexpr std::uint32_t kSide = 128;  ///< a power of two
    static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

    struct Node {
        Cell cell = kNone;
        Slot next = kNone;
        Slot previous = kNone;
    };

    std::vector<Node> nodes_;  // by slot
    std::vector<Slot> heads_ = std::vector<Slot>(kSide * kSide, kNone);
};

}  // namespace zoned::ai

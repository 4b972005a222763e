// ORCA lines: the allowed velocities of eight agents as half-planes, and their solver.
#pragma once

#include "kernels/include/kernel_base.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace zoned::ai::steering {

using kernels::kLanes;
using kernels::LaneInts;
using kernels::Lanes;

/// The lanes in which a comparison holds, as bits.
inline unsigned bits_of(const LaneInts& mask) {
#ifdef __AVX__
    Lanes as_floats;
    std::memcpy(&as_floats, &mask, sizeof(mask));
    return static_cast<unsigned>(__builtin_ia32_movmskps256(as_floats));
#else
    unsigned bits = 0;
    for (std::size_t i = 0; i < kLanes; ++i) {
        bits |= mask[i] != 0 ? 1U << i : 0U;
    }
    return bits;
#endif
}

inline Lanes splat(float value) {
    return Lanes{} + value;
}

inline Lanes pick(const LaneInts& mask, const Lanes& a, const Lanes& b) {
    return mask ? a : b;
}

/// Velocities v with n v >= c; n is of unit length, or zero with c < 0 for all velocities.
struct OrcaLine {
    Lanes nx, nz, c;
};

/// A row holds one half-plane for each of eight agents. Agents have different numbers of
/// half-planes; a missing one allows everything.
template <std::size_t kMost>
class OrcaLineSet {
  public:
    /// Adds `plane` to the lanes in `bits`. False where some lane is full: its bit is then in
    /// `full`, and the weakest of its half-planes is lost.
    void add(unsigned bits, const OrcaLine& plane) {
        while (bits != 0) {
            const auto lane = static_cast<std::size_t>(__builtin_ctz(bits));
            bits &= bits - 1;
            std::size_t at = count_[lane];
            if (at == kMost) {
                full_ |= 1U << lane;
                at = weakest(lane);
                const float weaker =
                    row_[at].c[lane] < plane.c[lane] ? row_[at].c[lane] : plane.c[lane];
                lost_[lane] = weaker > lost_[lane] ? weaker : lost_[lane];
                if (row_[at].c[lane] >= plane.c[lane]) {
                    continue;
                }
            } else {
                if (at == rows_) {
                    row_[rows_++] = {Lanes{}, Lanes{}, splat(-1.0F)};
                }
                ++count_[lane];
            }
            row_[at].nx[lane] = plane.nx[lane];
            row_[at].nz[lane] = plane.nz[lane];
            row_[at].c[lane] = plane.c[lane];
        }
    }

    [[nodiscard]] std::size_t rows() const { return rows_; }

    [[nodiscard]] const OrcaLine& row(std::size_t i) const { return row_[i]; }

    [[nodiscard]] unsigned full() const { return full_; }

    /// In each lane the largest c of the lost half-planes; less than any speed where none was lost.
    [[nodiscard]] const Lanes& lost() const { return lost_; }

  private:
    [[nodiscard]] std::size_t weakest(std::size_t lane) const {
        std::size_t least = 0;
        for (std::size_t i = 1; i < kMost; ++i) {
            least = row_[i].c[lane] < row_[least].c[lane] ? i : least;
        }
        return least;
    }

    std::array<OrcaLine, kMost> row_;
    std::array<std::uint8_t, kLanes> count_{};
    std::size_t rows_ = 0;
    unsigned full_ = 0;
    Lanes lost_ = splat(-1e30F);
};

struct OrcaVelocity {
    Lanes x, z;
};

/// OrcaProgram: the input of the solver. The first `fixed` half-planes hold as they are; a slack
/// may move the others.
struct OrcaProgram {
    static constexpr std::size_t kMostRows = 80;
    std::array<const OrcaLine*, kMostRows> row;
    std::size_t rows = 0;
    std::size_t fixed = 0;
    OrcaVelocity want;  ///< at most most_speed
    Lanes most_speed;

    template <std::size_t kMost>
    void append(const OrcaLineSet<kMost>& section) {
        for (std::size_t i = 0; i < section.rows(); ++i) {
            row[rows++] = &section.row(i);
        }
    }
};

struct OrcaSolution {
    OrcaVelocity v;
    /// Number of the row at which no velocity was left; the number of rows where none failed.
    LaneInts failed_at;
    LaneInts gave_way;  ///< lanes that needed slack
};

/// The velocity nearest to each lane's desired one within all its half-planes and its disc of
/// speeds. The method is the incremental linear programme in two dimensions, in the rows' order, in
/// all lanes at once. Sources: de Berg, Cheong, van Kreveld and Overmars, "Computational Geometry",
/// 3rd ed., 4.3; for this use van den Berg et al. 2011, section 5. Planes that are not fixed are
/// moved by `slack` (m/s, >= 0). In a lane that fails, v satisfies the rows before the failing one.
OrcaSolution solve(const OrcaProgram& program, const Lanes& slack);

/// The same with the least slack in each lane that fails at a row that is not fixed. The slack is
/// searched up to `most_slack` in so many halvings; most_slack is enough in all of those lanes.
/// `failed_at` reports the failures that remain.
OrcaSolution solve_with_slack(const OrcaProgram& program, const Lanes& most_slack, int halvings);

}  // namespace zoned::ai::steering

// ORCA lines: the half-planes of velocities that eight agents may choose, and the best velocity.
#pragma once

#include "kernels/include/kernel_base.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace zoned::ai::steering {

using kernels::kLanes;
using kernels::LaneInts;
using kernels::Lanes;

/// Lanes in which a comparison holds, as bits.
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

/// A row of half-planes holds one of each of eight agents; agents have different numbers of them,
/// what is missing allows everything.
template <std::size_t kMost>
class OrcaLineSet {
  public:
    /// Adds to the lanes in `bits` what they find there. False where some lane is full: its bit is
    /// then in `full`, and of its half-planes the weakest is lost.
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

    /// In each lane the largest c of those that were lost; less than any speed where none was.
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

/// What has to be solved: the first `fixed` half-planes hold as they are, the others may be
/// moved by a slack.
struct OrcaProgram {
    static constexpr std::size_t kMostRows = 80;
    std::array<const OrcaLine*, kMostRows> row;
    std::size_t rows = 0;
    std::size_t fixed = 0;
    OrcaVelocity want;  ///< at most as fast as most_speed
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
    /// Number of the row at which there was nothing left to choose from; rows where there was.
    LaneInts failed_at;
    LaneInts gave_way;  ///< lanes that needed slack
};

/// The velocity nearest to what each lane wants within all its half-planes and its disc of speeds:
/// the incremental linear programme in two dimensions (de Berg, Cheong, van Kreveld and Overmars,
/// "Computational Geometry", 3rd ed., 4.3; in this use: van den Berg et al. 2011, section 5), in
/// the rows' order, in all lanes at once. Planes that are not fixed give way by `slack` (m/s, >=
/// 0). In a lane that fails, v satisfies the rows before the failing one.
OrcaSolution solve(const OrcaProgram& program, const Lanes& slack);

/// The same with the least slack, up to `most_slack` in so many halvings, in each lane that fails
/// at a row that is not fixed (most_slack is enough in all of them). `failed_at` of what remains.
OrcaSolution solve_with_slack(const OrcaProgram& program, const Lanes& most_slack, int halvings);

}  // namespace zoned::ai::steering

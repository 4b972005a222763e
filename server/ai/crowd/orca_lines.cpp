// build: hot loops
#include "server/ai/crowd/orca_lines.h"

namespace zoned::ai::steering {

namespace {

/// Two directions whose sine is smaller count as parallel.
constexpr float kParallel = 1e-5F;

Lanes lesser(const Lanes& a, const Lanes& b) {
    return a < b ? a : b;
}

Lanes greater(const Lanes& a, const Lanes& b) {
    return a > b ? a : b;
}

Lanes absolute(const Lanes& a) {
    return a < 0.0F ? -a : a;
}

/// A piece of a line of velocities: t from low to high, empty where low > high.
struct LanePiece {
    Lanes low, high;
};

/// The best velocity on the border of plane k within the disc and the planes before k.
OrcaVelocity along_border(const OrcaProgram& p,
                          const Lanes& slack,
                          std::size_t k,
                          const OrcaVelocity& want,
                          LaneInts& nothing) {
    const OrcaLine& own = *p.row[k];
    const Lanes none{};
    const Lanes c = k >= p.fixed ? own.c - slack : own.c;
    const Lanes left = p.most_speed * p.most_speed - c * c;
    nothing = left < none;
    const Lanes reach = kernels::zk_sqrt(pick(nothing, none, left));
    // The border: c n + t d with d = (nz, -nx).
    LanePiece piece{-reach, reach};
    for (std::size_t j = 0; j < k; ++j) {
        const OrcaLine& other = *p.row[j];
        const Lanes other_c = j >= p.fixed ? other.c - slack : other.c;
        const Lanes slope = other.nx * own.nz - other.nz * own.nx;
        const Lanes lack = other_c - c * (other.nx * own.nx + other.nz * own.nz);
        const LaneInts parallel = absolute(slope) < kParallel;
        const Lanes t = lack / pick(parallel, splat(1.0F), slope);
        nothing = nothing | (parallel & (lack > 0.0F));
        const LaneInts from_below = (slope > 0.0F) & ~parallel;
        const LaneInts from_above = (slope < 0.0F) & ~parallel;
        piece.low = pick(from_below, greater(piece.low, t), piece.low);
        piece.high = pick(from_above, lesser(piece.high, t), piece.high);
    }
    nothing = nothing | (piece.low > piece.high);
    const Lanes wanted = want.x * own.nz - want.z * own.nx;
    const Lanes t = lesser(greater(wanted, piece.low), piece.high);
    return {c * own.nx + t * own.nz, c * own.nz - t * own.nx};
}

}  // namespace

OrcaSolution solve(const OrcaProgram& p, const Lanes& slack) {
    const auto rows = static_cast<std::int32_t>(p.rows);
    OrcaSolution s{p.want, LaneInts{} + rows, LaneInts{}};
    for (std::size_t k = 0; k < p.rows; ++k) {
        const OrcaLine& plane = *p.row[k];
        const Lanes c = k >= p.fixed ? plane.c - slack : plane.c;
        const LaneInts going = s.failed_at == rows;
        const LaneInts outside = (plane.nx * s.v.x + plane.nz * s.v.z < c) & going;
        if (bits_of(outside) == 0) {
            continue;
        }
        LaneInts nothing;
        const OrcaVelocity moved = along_border(p, slack, k, p.want, nothing);
        const LaneInts found = outside & ~nothing;
        s.v.x = pick(found, moved.x, s.v.x);
        s.v.z = pick(found, moved.z, s.v.z);
        s.failed_at = (outside & nothing) ? LaneInts{} + static_cast<std::int32_t>(k) : s.failed_at;
    }
    return s;
}

OrcaSolution solve_with_slack(const OrcaProgram& p, const Lanes& most_slack, int halvings) {
    const auto rows = static_cast<std::int32_t>(p.rows);
    const auto fixed = static_cast<std::int32_t>(p.fixed);
    OrcaSolution best = solve(p, Lanes{});
    const LaneInts wanting = (best.failed_at < rows) & (best.failed_at >= fixed);
    if (bits_of(wanting) == 0) {
        return best;
    }
    best.gave_way = wanting;
    // A slack of `enough` suffices, `less` does not; lanes that need none keep theirs.
    Lanes less{};
    Lanes enough = pick(wanting, most_slack, Lanes{});
    for (int i = 0; i <= halvings; ++i) {
        const Lanes tried = i == 0 ? enough : 0.5F * (less + enough);
        const OrcaSolution s = solve(p, tried);
        const LaneInts does = (s.failed_at == rows) & wanting;
        best.v.x = pick(does, s.v.x, best.v.x);
        best.v.z = pick(does, s.v.z, best.v.z);
        best.failed_at = does ? s.failed_at : best.failed_at;
        enough = pick(does, tried, enough);
        less = pick(wanting & ~does, tried, less);
    }
    return best;
}

}  // namespace zoned::ai::steering

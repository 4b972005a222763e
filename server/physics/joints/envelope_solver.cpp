// build: hot loops
#include "server/physics/joints/envelope_solver.h"

#include <algorithm>
#include <cstring>

namespace zoned::physics {

namespace {

/// Entries beside each row that loops may touch: zeros behind it, of no meaning before.
constexpr std::size_t kMargin = 8;
/// Numbers that the processor takes at a time.
constexpr std::size_t kWide = 4;
/// Rows that are taken from another in one pass over it.
constexpr std::size_t kPivots = 4;

typedef double Doubles __attribute__((vector_size(8 * kWide)));

[[gnu::always_inline]] inline Doubles load_doubles(const double* from) {
    Doubles out;
    std::memcpy(&out, from, sizeof(out));
    return out;
}

[[gnu::always_inline]] inline void store(double* to, const Doubles& value) {
    std::memcpy(to, &value, sizeof(value));
}

/// Takes `share` times a row from another, from `from` to `last`.
[[gnu::always_inline]] inline void take(double* row,
                                        const double* other,
                                        double share,
                                        std::size_t from,
                                        std::size_t last) {
    for (std::size_t j = from; j <= last; j += kWide) {
        store(row + j, load_doubles(row + j) - share * load_doubles(other + j));
    }
}

}  // namespace

void EnvelopeSolver::shape(std::span<const std::uint32_t> start) {
    const std::size_t rows = start.size();
    start_.assign(start.begin(), start.end());
    for (std::size_t i = rows; i-- > 1;) {
        start_[i - 1] = std::min(start_[i - 1], start_[i]);
    }
    end_.resize(rows);
    for (std::size_t i = 0, k = 0; i <= rows; ++i) {
        for (const std::size_t reached = i < rows ? start_[i] : rows; k < reached; ++k) {
            end_[k] = static_cast<std::uint32_t>(i - 1);
        }
    }
    first_.resize(rows);
    std::size_t size = 0;
    for (std::size_t k = 0; k < rows; ++k) {
        size += kMargin;
        first_[k] = static_cast<std::ptrdiff_t>(size) - static_cast<std::ptrdiff_t>(k);
        size += end_[std::min(k + kPivots, rows) - 1] - k + 1 + kMargin;
    }
    entries_.assign(size, 0.0);
    inverse_.assign(rows, 0.0);
    work_.assign(rows + kMargin, 0.0);
}

void EnvelopeSolver::clear(std::size_t begin, std::size_t end) {
    if (begin < end) {
        double* const last = row(end - 1) + end_[std::min(end - 1 + kPivots, size()) - 1] + 1;
        std::fill(row(begin) + begin - kMargin, last + kMargin, 0.0);
    }
}

void EnvelopeSolver::factor(std::size_t begin, std::size_t end, double least) {
    for (std::size_t i = begin; i < end; ++i) {
        double* const mine = row(i);
        const double whole = mine[i];
        std::size_t k = start_[i];
        for (; k + kPivots <= i; k += kPivots) {
            const double* const r0 = row(k);
            const double* const r1 = row(k + 1);
            const double* const r2 = row(k + 2);
            const double* const r3 = row(k + 3);
            const double s0 = r0[i] * inverse_[k];
            const double s1 = r1[i] * inverse_[k + 1];
            const double s2 = r2[i] * inverse_[k + 2];
            const double s3 = r3[i] * inverse_[k + 3];
            if (s0 == 0.0 && s1 == 0.0 && s2 == 0.0 && s3 == 0.0) {
                continue;
            }
            for (std::size_t j = i; j <= end_[k + 3]; j += kWide) {
                Doubles at = load_doubles(mine + j);
                at -= s0 * load_doubles(r0 + j);
                at -= s1 * load_doubles(r1 + j);
                at -= s2 * load_doubles(r2 + j);
                at -= s3 * load_doubles(r3 + j);
                store(mine + j, at);
            }
        }
        for (; k < i; ++k) {
            take(mine, row(k), row(k)[i] * inverse_[k], i, end_[k]);
        }
        // The rest of the diagonal after rounding says whether the row depends on those before.
        inverse_[i] = mine[i] > least * whole ? 1.0 / mine[i] : 0.0;
    }
}

void EnvelopeSolver::solve(std::span<double> b, std::size_t begin, std::size_t end) {
    // No other rows' numbers lie behind those that are solved: not finite, they would spread.
    double* const x = work_.data() - begin;
    std::copy(b.data() + begin, b.data() + end, x + begin);
    std::fill(x + end, x + end + kMargin, 0.0);
    for (std::size_t k = begin; k < end; ++k) {
        const double share = x[k] * inverse_[k];
        take(x, row(k), share, k + 1, end_[k]);
        x[k] = share;
    }
    for (std::size_t k = end; k-- > begin;) {
        const double* const mine = row(k);
        Doubles sum{};
        for (std::size_t j = k + 1; j <= end_[k]; j += kWide) {
            sum += load_doubles(mine + j) * load_doubles(x + j);
        }
        x[k] -= inverse_[k] * ((sum[0] + sum[2]) + (sum[1] + sum[3]));
        b[k] = x[k];
    }
}

double EnvelopeSolver::cost(std::span<const std::uint32_t> start, std::size_t first) {
    double sum = 0.0;
    for (std::size_t i = 0; i < start.size(); ++i) {
        const auto width = static_cast<double>(first + i - start[i] + 1);
        sum += 0.5 * width * width;
    }
    return sum;
}

}  // namespace zoned::physics

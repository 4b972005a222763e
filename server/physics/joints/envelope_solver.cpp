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

[[gnu::always_inline]] inline double sum_of(const Doubles& a) {
    return (a[0] + a[2]) + (a[1] + a[3]);
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

/// Takes four unknowns out of those after them. `x` begins at row `begin`, and k counts from there.
[[gnu::always_inline]] inline void EnvelopeSolver::solve_forward(double* x,
                                                                 std::size_t begin,
                                                                 std::size_t k) {
    const double* const r0 = row(begin + k) + begin;
    const double* const r1 = row(begin + k + 1) + begin;
    const double* const r2 = row(begin + k + 2) + begin;
    const double* const r3 = row(begin + k + 3) + begin;
    const double* const inverse = &inverse_[begin + k];
    const double s0 = x[k] * inverse[0];
    const double s1 = (x[k + 1] - s0 * r0[k + 1]) * inverse[1];
    const double s2 = ((x[k + 2] - s0 * r0[k + 2]) - s1 * r1[k + 2]) * inverse[2];
    const double s3 =
        (((x[k + 3] - s0 * r0[k + 3]) - s1 * r1[k + 3]) - s2 * r2[k + 3]) * inverse[3];
    const std::size_t last = end_[begin + k + 3] - begin;
    for (std::size_t j = k + kPivots; j <= last; j += kWide) {
        Doubles at = load_doubles(x + j);
        at -= s0 * load_doubles(r0 + j);
        at -= s1 * load_doubles(r1 + j);
        at -= s2 * load_doubles(r2 + j);
        at -= s3 * load_doubles(r3 + j);
        store(x + j, at);
    }
    store(x + k, Doubles{s0, s1, s2, s3});
}

[[gnu::always_inline]] inline void EnvelopeSolver::solve_backward(double* x,
                                                                  std::size_t begin,
                                                                  std::size_t k) {
    const double* const r0 = row(begin + k) + begin;
    const double* const r1 = row(begin + k + 1) + begin;
    const double* const r2 = row(begin + k + 2) + begin;
    const double* const r3 = row(begin + k + 3) + begin;
    const double* const inverse = &inverse_[begin + k];
    Doubles sum0{};
    Doubles sum1{};
    Doubles sum2{};
    Doubles sum3{};
    const std::size_t last = end_[begin + k + 3] - begin;
    for (std::size_t j = k + kPivots; j <= last; j += kWide) {
        const Doubles at = load_doubles(x + j);
        sum0 += load_doubles(r0 + j) * at;
        sum1 += load_doubles(r1 + j) * at;
        sum2 += load_doubles(r2 + j) * at;
        sum3 += load_doubles(r3 + j) * at;
    }
    const double x3 = x[k + 3] - inverse[3] * sum_of(sum3);
    const double x2 = x[k + 2] - inverse[2] * (sum_of(sum2) + r2[k + 3] * x3);
    const double x1 = x[k + 1] - inverse[1] * ((sum_of(sum1) + r1[k + 3] * x3) + r1[k + 2] * x2);
    const double x0 =
        x[k] - inverse[0] * (((sum_of(sum0) + r0[k + 3] * x3) + r0[k + 2] * x2) + r0[k + 1] * x1);
    store(x + k, Doubles{x0, x1, x2, x3});
}

void EnvelopeSolver::solve(std::span<double> b, std::size_t begin, std::size_t end) {
    // No other rows' numbers lie behind those that are solved: not finite, they would spread.
    double* const x = work_.data();
    const std::size_t size = end - begin;
    std::copy(b.data() + begin, b.data() + end, x);
    std::fill(x + size, x + size + kMargin, 0.0);
    const std::size_t whole = size / kPivots * kPivots;
    for (std::size_t k = 0; k < whole; k += kPivots) {
        solve_forward(x, begin, k);
    }
    for (std::size_t k = whole; k < size; ++k) {
        x[k] *= inverse_[begin + k];
        for (std::size_t j = k + 1; j < size; ++j) {
            x[j] -= x[k] * row(begin + k)[begin + j];
        }
    }
    for (std::size_t k = size; k-- > whole;) {
        double sum = 0.0;
        for (std::size_t j = k + 1; j < size; ++j) {
            sum += row(begin + k)[begin + j] * x[j];
        }
        x[k] -= inverse_[begin + k] * sum;
    }
    for (std::size_t k = whole; k > 0; k -= kPivots) {
        solve_backward(x, begin, k - kPivots);
    }
    std::copy(x, x + size, b.data() + begin);
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

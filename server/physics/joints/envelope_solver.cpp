#include "server/physics/joints/envelope_solver.h"

#include <algorithm>

namespace zoned::physics {

void EnvelopeSolver::shape(std::span<const std::uint32_t> start) {
    start_.assign(start.begin(), start.end());
    first_.resize(start.size());
    std::ptrdiff_t size = 0;
    for (std::size_t i = 0; i < start.size(); ++i) {
        first_[i] = size - static_cast<std::ptrdiff_t>(start[i]);
        size += static_cast<std::ptrdiff_t>(i - start[i] + 1);
    }
    entries_.assign(static_cast<std::size_t>(size), 0.0);
    inverse_.assign(start.size(), 0.0);
}

void EnvelopeSolver::clear(std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
        double* row = entries_.data() + first_[i];
        std::fill(row + start_[i], row + i + 1, 0.0);
    }
}

void EnvelopeSolver::factor(std::size_t begin, std::size_t end, double least) {
    for (std::size_t i = begin; i < end; ++i) {
        double* row = entries_.data() + first_[i];
        // First the rows of L D, then L and the pivot from them.
        for (std::size_t j = start_[i]; j < i; ++j) {
            const double* other = entries_.data() + first_[j];
            double sum = row[j];
            for (std::size_t k = std::max(start_[i], start_[j]); k < j; ++k) {
                sum -= row[k] * other[k];
            }
            row[j] = sum;
        }
        const double whole = row[i];
        double pivot = whole;
        for (std::size_t j = start_[i]; j < i; ++j) {
            const double scaled = row[j] * inverse_[j];
            pivot -= scaled * row[j];
            row[j] = scaled;
        }
        // The rest of the diagonal after rounding says whether the row depends on those before.
        inverse_[i] = pivot > least * whole ? 1.0 / pivot : 0.0;
    }
}

void EnvelopeSolver::solve(std::span<double> b, std::size_t begin, std::size_t end) const {
    for (std::size_t i = begin; i < end; ++i) {
        const double* row = entries_.data() + first_[i];
        double sum = b[i];
        for (std::size_t k = start_[i]; k < i; ++k) {
            sum -= row[k] * b[k];
        }
        b[i] = sum;
    }
    for (std::size_t i = begin; i < end; ++i) {
        b[i] *= inverse_[i];
    }
    for (std::size_t i = end; i-- > begin;) {
        const double* row = entries_.data() + first_[i];
        for (std::size_t k = start_[i]; k < i; ++k) {
            b[k] -= row[k] * b[i];
        }
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

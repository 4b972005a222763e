#include "server/ai/splines/racing_line.h"

#include "shared/core/assert.h"

#include <algorithm>

namespace zoned::ai::splines {

namespace {

constexpr std::size_t kCoarsest = 16;

/// Samples of a spline: places on its middle, and the direction to the right.
struct Samples {
    std::vector<Vec2d> middle, right;

    Samples(const Spline& track, std::size_t count) {
        for (std::size_t i = 0; i < count; ++i) {
            const SplinePoint p =
                track.at(track.length() * static_cast<double>(i) / static_cast<double>(count));
            middle.push_back(p.at);
            right.push_back({-p.ahead.y(), p.ahead.x()});
        }
    }

    [[nodiscard]] Vec2d place(const std::vector<double>& offset, std::size_t i) const {
        return middle[i] + offset[i] * right[i];
    }

    [[nodiscard]] Vec2d second_difference(const std::vector<double>& offset, std::size_t i) const {
        const std::size_t n = middle.size();
        return place(offset, (i + n - 1) % n) - 2.0 * place(offset, i) + place(offset, (i + 1) % n);
    }
};

/// Moves each offset in turn to where the sum is least while the others stay as they are. An offset
/// enters three second differences, with -2 in one and 1 in two, so the sum of squares is quadratic
/// in it.
void sweep(const Samples& samples, std::vector<double>& offset, double most) {
    const std::size_t n = offset.size();
    for (std::size_t i = 0; i < n; ++i) {
        const Vec2d pull = samples.second_difference(offset, (i + n - 1) % n) -
                           2.0 * samples.second_difference(offset, i) +
                           samples.second_difference(offset, (i + 1) % n);
        offset[i] = std::clamp(offset[i] - pull.dot(samples.right[i]) / 6.0, -most, most);
    }
}

}  // namespace

RacingLine racing_line(const Spline& track, std::size_t samples, double margin_m, int sweeps) {
    const double most = 0.5 * static_cast<double>(track.width()) - margin_m;
    ZONED_ASSERT(track.closed() && samples >= kCoarsest && samples <= 65'536 &&
                     (samples & (samples - 1)) == 0 && most >= 0.0 && margin_m >= 0.0,
                 "a closed track, a power of two samples, a margin within its width");
    RacingLine line;
    line.offset.assign(kCoarsest, 0.0);
    for (std::size_t n = kCoarsest;; n *= 2) {
        const Samples at(track, n);
        for (int i = 0; i < sweeps; ++i) {
            sweep(at, line.offset, most);
        }
        if (n == samples) {
            for (std::size_t i = 0; i < n; ++i) {
                line.bend += at.second_difference(line.offset, i).squaredNorm();
            }
            return line;
        }
        std::vector<double> finer;
        for (std::size_t i = 0; i < n; ++i) {
            finer.push_back(line.offset[i]);
            finer.push_back(0.5 * (line.offset[i] + line.offset[(i + 1) % n]));
        }
        line.offset = std::move(finer);
    }
}

core::Result<Spline> track_along(const Spline& track, const RacingLine& line) {
    SplineDef def;
    def.closed = true;
    def.width_m = 0.25F * track.width();
    const std::size_t n = line.offset.size();
    for (std::size_t i = 0; i < n; ++i) {
        const SplinePoint p = track.beside(
            track.length() * static_cast<double>(i) / static_cast<double>(n), line.offset[i]);
        def.points.push_back(p.at.cast<float>());
    }
    return Spline::make(def);
}

}  // namespace zoned::ai::splines

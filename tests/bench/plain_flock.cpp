// build: hot loops
#include "tests/bench/plain_flock.h"

#include <algorithm>
#include <cmath>

namespace zoned::bench {

namespace {

int cell_at(float at, float cells_per_m, int count) {
    return std::clamp(static_cast<int>(std::floor(at * cells_per_m)), 0, count - 1);
}

float home(float x, float low, float high, float push) {
    return x < low ? push : x > high ? -push : 0.0F;
}

}  // namespace

void PlainFlock::sort() {
    const kernels::FlockRules& r = rules;
    const float radius = std::sqrt(r.radius2);
    const float per_m = 1.0F / radius;
    const auto columns = static_cast<int>(std::ceil((r.high_x - r.low_x) / radius));
    const auto rows = static_cast<int>(std::ceil((r.high_z - r.low_z) / radius));
    columns_ = columns;
    rows_ = rows;
    begin_.assign(static_cast<std::size_t>(columns * rows) + 1, 0);
    cell_.resize(agents.size());
    list_.resize(agents.size());
    for (std::size_t i = 0; i < agents.size(); ++i) {
        cell_[i] = cell_at(agents[i].z - r.low_z, per_m, rows) * columns +
                   cell_at(agents[i].x - r.low_x, per_m, columns);
        ++begin_[static_cast<std::size_t>(cell_[i]) + 1];
    }
    for (std::size_t c = 1; c < begin_.size(); ++c) {
        begin_[c] += begin_[c - 1];
    }
    std::vector<int> next(begin_.begin(), begin_.end() - 1);
    for (std::size_t i = 0; i < agents.size(); ++i) {
        list_[static_cast<std::size_t>(next[static_cast<std::size_t>(cell_[i])]++)] =
            static_cast<int>(i);
    }
}

PlainFlock::Agent PlainFlock::moved(std::size_t i) {
    const kernels::FlockRules& r = rules;
    Agent a = agents[i];
    float count = 0.0F;
    float px = 0.0F, py = 0.0F, pz = 0.0F;
    float mx = 0.0F, my = 0.0F, mz = 0.0F;
    float sx = 0.0F, sy = 0.0F, sz = 0.0F;
    const int column = cell_[i] % columns_;
    const int row = cell_[i] / columns_;
    for (int k = std::max(row - 1, 0); k <= std::min(row + 1, rows_ - 1); ++k) {
        for (int c = std::max(column - 1, 0); c <= std::min(column + 1, columns_ - 1); ++c) {
            const auto cell = static_cast<std::size_t>(k * columns_ + c);
            for (int at = begin_[cell]; at < begin_[cell + 1]; ++at) {
                const Agent& n =
                    agents[static_cast<std::size_t>(list_[static_cast<std::size_t>(at)])];
                ++tested;
                const float dx = n.x - a.x;
                const float dy = n.y - a.y;
                const float dz = n.z - a.z;
                const float d2 = dx * dx + dy * dy + dz * dz;
                if (d2 >= r.radius2 || d2 <= 0.0F) {
                    continue;
                }
                count += 1.0F;
                px += dx;
                py += dy;
                pz += dz;
                mx += n.vx;
                my += n.vy;
                mz += n.vz;
                if (d2 < r.separation2) {
                    const float push = 1.0F / d2;
                    sx -= push * dx;
                    sy -= push * dy;
                    sz -= push * dz;
                }
            }
        }
    }
    float ax = sx * r.separation;
    float ay = sy * r.separation;
    float az = sz * r.separation;
    if (count > 0.0F) {
        const float share = 1.0F / count;
        ax += px * share * r.cohesion + (mx * share - a.vx) * r.alignment;
        ay += py * share * r.cohesion + (my * share - a.vy) * r.alignment;
        az += pz * share * r.cohesion + (mz * share - a.vz) * r.alignment;
    }
    const float a2 = ax * ax + ay * ay + az * az;
    if (a2 > r.most_acceleration * r.most_acceleration) {
        const float cut = r.most_acceleration / std::sqrt(a2);
        ax *= cut;
        ay *= cut;
        az *= cut;
    }
    const float hx = home(a.x, r.low_x, r.high_x, r.turn_back);
    const float hy = home(a.y, r.low_y, r.high_y, r.turn_back);
    const float hz = home(a.z, r.low_z, r.high_z, r.turn_back);
    a.vx += r.h * (ax + hx);
    a.vy += r.h * (ay + hy);
    a.vz += r.h * (az + hz);
    const float speed = std::sqrt(a.vx * a.vx + a.vy * a.vy + a.vz * a.vz);
    if (speed > 0.0F) {
        const bool outside = hx * hx + hy * hy + hz * hz > 0.0F;
        const float scale = std::clamp(speed, outside ? 0.0F : r.least_speed, r.most_speed) / speed;
        a.vx *= scale;
        a.vy *= scale;
        a.vz *= scale;
    }
    a.x += r.h * a.vx;
    a.y += r.h * a.vy;
    a.z += r.h * a.vz;
    return a;
}

void PlainFlock::step() {
    tested = 0;
    sort();
    next_.resize(agents.size());
    for (std::size_t i = 0; i < agents.size(); ++i) {
        next_[i] = moved(i);
    }
    agents.swap(next_);
}

}  // namespace zoned::bench

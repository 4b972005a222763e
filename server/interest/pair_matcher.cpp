// build: hot loops
#include "server/interest/pair_matcher.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>

namespace zoned::interest {

namespace {

constexpr std::size_t kKindsPerType = world::kStances;
/// The viewers of a strip are parted into so many stretches.
constexpr std::uint32_t kStretches = 16;

}  // namespace

void PairMatcher::step(const world::Entities& entities,
                       const world::TypeTable& types,
                       std::span<const world::Viewer> viewers,
                       Pairs& out) {
    read_entities(entities, types);
    read_viewers(entities, types, viewers);
    row_grid_.build({x_, z_, aura_}, std::max(1.0F, std::min(largest_nimbus_m_, largest_aura_m_)));
    order_queries();
    ends_.resize(queries_.size());
    row_grid_.match(queries_, 0, out.rows, ends_);
    out.first.assign(viewers.size(), 0);
    out.count.assign(viewers.size(), 0);
    std::uint32_t begin = 0;
    for (std::size_t i = 0; i < queries_.size(); ++i) {
        out.first[viewer_of_[i]] = begin;
        out.count[viewer_of_[i]] = ends_[i] - begin;
        begin = ends_[i];
    }
    out.size = begin;
}

/// Counting sort of the queries, so that neighbours in the plane follow each other: stretch by
/// stretch, and through a stretch strip by strip.
void PairMatcher::order_queries() {
    const RowGrid::RowGridCells cells = row_grid_.cells();
    const std::uint32_t per_stretch = cells.columns / kStretches + 1;
    const std::size_t size = asked_.size();
    place_.resize(size);
    place_begin_.assign(static_cast<std::size_t>(cells.strips) * kStretches + 1, 0);
    for (std::size_t i = 0; i < size; ++i) {
        const std::uint32_t stretch = cells.column(asked_[i].x) / per_stretch;
        place_[i] = stretch * cells.strips + cells.strip(asked_[i].z);
        ++place_begin_[place_[i] + 1];
    }
    for (std::size_t place = 1; place < place_begin_.size(); ++place) {
        place_begin_[place] += place_begin_[place - 1];
    }
    queries_.resize(size);
    viewer_of_.resize(size);
    for (std::size_t i = 0; i < size; ++i) {
        const std::uint32_t at = place_begin_[place_[i]]++;
        queries_[at] = asked_[i];
        viewer_of_[at] = asker_[i];
    }
}

void PairMatcher::read_entities(const world::Entities& e, const world::TypeTable& types) {
    aura_of_.resize(2 * types.size() * kKindsPerType);
    largest_aura_m_ = 0.0F;
    for (std::size_t kind = 0; kind < types.size() * kKindsPerType; ++kind) {
        const float aura = std::max(0.0F, types[kind / kKindsPerType].aura_m[kind % kKindsPerType]);
        aura_of_[2 * kind] = aura;
        aura_of_[2 * kind + 1] = 0.0F;  // hidden
        largest_aura_m_ = std::max(largest_aura_m_, aura);
    }
    const std::size_t size = e.size();
    x_.resize(size);
    z_.resize(size);
    aura_.resize(size);
    // Where columns begin is read once, and not after each write.
    const Vec3* const position = e.position.data();
    float* const x = x_.data();
    float* const z = z_.data();
    float* const aura = aura_.data();
    for (std::size_t row = 0; row < size; ++row) {
        x[row] = position[row].x();
        z[row] = position[row].z();
    }
    const TypeIndex* const type = e.type.data();
    const std::uint8_t* const stance = e.stance.data();
    const std::uint8_t* const flags = e.flags.data();
    const float* const aura_of = aura_of_.data();
    for (std::size_t row = 0; row < size; ++row) {
        ZONED_ASSERT(stance[row] < kKindsPerType, "a stance has radii");
        const std::size_t kind = type[row] * kKindsPerType + stance[row];
        aura[row] = aura_of[2 * kind + ((flags[row] & world::kHidden) != 0 ? 1 : 0)];
    }
    for (std::size_t row = 0; row < size; ++row) {
        // Neither infinite nor not a number.
        const bool somewhere = (x[row] - x[row]) + (z[row] - z[row]) == 0.0F;
        aura[row] = somewhere ? aura[row] : 0.0F;
    }
}

void PairMatcher::read_viewers(const world::Entities& entities,
                               const world::TypeTable& types,
                               std::span<const world::Viewer> viewers) {
    viewer_row_.resize(viewers.size());
    asked_.clear();
    asker_.clear();
    largest_nimbus_m_ = 0.0F;
    for (std::uint32_t i = 0; i < viewers.size(); ++i) {
        // A viewer's avatar has mostly the row that it had.
        world::Row row = viewer_row_[i];
        if (row >= entities.size() || entities.id[row] != viewers[i].avatar) {
            row = entities.find(viewers[i].avatar);
            viewer_row_[i] = row;
        }
        if (row == world::kNoRow || !std::isfinite(x_[row]) || !std::isfinite(z_[row])) {
            continue;
        }
        const float nimbus = types[entities.type[row]].nimbus_m[entities.stance[row]];
        if (nimbus > 0.0F) {
            asked_.push_back({x_[row], z_[row], nimbus, row});
            asker_.push_back(i);
            largest_nimbus_m_ = std::max(largest_nimbus_m_, nimbus);
        }
    }
}

}  // namespace zoned::interest

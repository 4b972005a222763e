#include "server/interest/pair_matcher.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>

namespace zoned::interest {

void PairMatcher::step(const world::Entities& entities,
                       const world::TypeTable& types,
                       std::span<const world::Viewer> viewers,
                       Pairs& out) {
    read_entities(entities, types);
    read_viewers(entities, types, viewers);
    const float radius = std::min(largest_nimbus_m_, largest_aura_m_);
    grid_.build({x_, z_, aura_}, std::max(1.0F, 1.0F * radius));
    order_viewers();
    out.first.assign(viewers.size(), 0);
    out.count.assign(viewers.size(), 0);
    std::size_t found = 0;
    for (const Place& at : order_) {
        if (out.rows.size() < found + x_.size() + spatial::kLanes) {
            out.rows.resize(2 * found + x_.size() + spatial::kLanes);
        }
        const std::size_t count =
            grid_.gather(at.x, at.z, at.nimbus_m, 1.0F, at.row, out.rows.data() + found);
        out.first[at.viewer] = static_cast<std::uint32_t>(found);
        out.count[at.viewer] = static_cast<std::uint32_t>(count);
        found += count;
    }
    out.size = found;
}

/// Counting sort of the viewers that hear at all.
void PairMatcher::order_viewers() {
    line_begin_.clear();
    const auto line_of = [&](std::size_t viewer) {
        return grid_.line_of(z_[viewer_row_[viewer]]);
    };
    std::uint32_t hearing = 0;
    for (std::size_t i = 0; i < viewer_row_.size(); ++i) {
        if (viewer_nimbus_[i] > 0.0F) {
            const std::uint32_t line = line_of(i);
            if (line + 2 > line_begin_.size()) {
                line_begin_.resize(line + 2, 0);
            }
            ++line_begin_[line + 1];
            ++hearing;
        }
    }
    for (std::size_t line = 1; line < line_begin_.size(); ++line) {
        line_begin_[line] += line_begin_[line - 1];
    }
    order_.resize(hearing);
    for (std::uint32_t i = 0; i < viewer_row_.size(); ++i) {
        if (viewer_nimbus_[i] > 0.0F) {
            const world::Row row = viewer_row_[i];
            order_[line_begin_[line_of(i)]++] = {i, row, x_[row], z_[row], viewer_nimbus_[i]};
        }
    }
}

void PairMatcher::read_entities(const world::Entities& e, const world::TypeTable& types) {
    constexpr std::size_t kBehaviours = world::kBehaviours;
    aura_of_.resize(types.size() * kBehaviours);
    for (std::size_t kind = 0; kind < aura_of_.size(); ++kind) {
        aura_of_[kind] = std::max(0.0F, types[kind / kBehaviours].aura_m[kind % kBehaviours]);
    }
    x_.resize(e.size());
    z_.resize(e.size());
    aura_.resize(e.size());
    for (world::Row row = 0; row < e.size(); ++row) {
        x_[row] = e.position[row].x();
        z_[row] = e.position[row].z();
        const bool heard =
            !e.has(row, world::kHidden) && std::isfinite(x_[row]) && std::isfinite(z_[row]);
        ZONED_ASSERT(e.behaviour[row] < kBehaviours, "a behaviour has radii");
        aura_[row] = heard ? aura_of_[e.type[row] * kBehaviours + e.behaviour[row]] : 0.0F;
    }
    largest_aura_m_ = 0.0F;
    for (const float aura : aura_of_) {
        largest_aura_m_ = std::max(largest_aura_m_, aura);
    }
}

void PairMatcher::read_viewers(const world::Entities& entities,
                               const world::TypeTable& types,
                               std::span<const world::Viewer> viewers) {
    viewer_row_.resize(viewers.size());
    viewer_nimbus_.resize(viewers.size());
    largest_nimbus_m_ = 0.0F;
    for (std::size_t i = 0; i < viewers.size(); ++i) {
        // A viewer's avatar has mostly the row that it had.
        world::Row row = viewer_row_[i];
        if (row >= entities.size() || entities.id[row] != viewers[i].avatar) {
            row = entities.find(viewers[i].avatar);
            viewer_row_[i] = row;
        }
        viewer_nimbus_[i] = 0.0F;
        if (row != world::kNoRow && std::isfinite(x_[row]) && std::isfinite(z_[row])) {
            viewer_nimbus_[i] = types[entities.type[row]].nimbus_m[entities.behaviour[row]];
            largest_nimbus_m_ = std::max(largest_nimbus_m_, viewer_nimbus_[i]);
        }
    }
}

}  // namespace zoned::interest

#include "server/physics/soft/spring_batches.h"

#include <algorithm>
#include <bit>

namespace zoned::physics::soft {

namespace {

constexpr std::uint32_t kShared = 64;  // colours that any number of springs may have

void put(SpringBatch& batch, std::size_t lane, const Spring& s, std::uint32_t index) {
    batch.a[lane] = s.a;
    batch.b[lane] = s.b;
    batch.spring[lane] = index;
    batch.rest[lane] = s.rest;
    batch.compliance[lane] = 1.0F / s.stiffness;
    batch.lag[lane] = s.damping / s.stiffness;
}

}  // namespace

void SpringBatches::build(std::span<const Spring> springs, std::size_t nodes) {
    // A spring at a node with more than 64 of them may find no shared colour: it gets its own.
    std::vector<std::uint64_t> taken(nodes, 0);
    std::vector<std::uint32_t> colour(springs.size(), 0);
    std::uint32_t lone = kShared;
    damped_ = false;
    for (std::size_t i = 0; i < springs.size(); ++i) {
        const Spring& s = springs[i];
        if (!s.alive) {
            continue;
        }
        const auto free = static_cast<std::uint32_t>(std::countr_one(taken[s.a] | taken[s.b]));
        colour[i] = free < kShared ? free : lone++;
        if (free < kShared) {
            taken[s.a] |= std::uint64_t{1} << free;
            taken[s.b] |= std::uint64_t{1} << free;
        }
        damped_ = damped_ || s.damping > 0.0F;
    }
    std::vector<std::vector<std::uint32_t>> members(lone);
    for (std::size_t i = 0; i < springs.size(); ++i) {
        if (springs[i].alive) {
            members[colour[i]].push_back(static_cast<std::uint32_t>(i));
        }
    }
    batches_.clear();
    first_.assign(1, 0);
    for (const std::vector<std::uint32_t>& m : members) {
        if (m.empty()) {
            continue;
        }
        for (std::size_t begin = 0; begin < m.size(); begin += kLanes) {
            SpringBatch& batch = batches_.emplace_back();
            for (std::size_t lane = 0; lane < kLanes; ++lane) {
                const std::uint32_t i = begin + lane < m.size() ? m[begin + lane] : m[begin];
                put(batch, lane, springs[i], i);
            }
        }
        first_.push_back(batches_.size());
    }
}

void SpringBatches::refresh(std::span<const Spring> springs) {
    for (SpringBatch& batch : batches_) {
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
            batch.rest[lane] = springs[batch.spring[lane]].rest;
        }
    }
}

}  // namespace zoned::physics::soft

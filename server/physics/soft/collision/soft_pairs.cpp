#include "server/physics/soft/collision/soft_pairs.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics::soft {

namespace {

/// A pair that is faster than this many substeps bear may overlap for some steps.
constexpr int kMostContactSubsteps = 32;
constexpr float kFarthestSweep = 1.0e4F;  // m: keeps boxes finite
constexpr std::uint32_t kNoIsland = 0xFFFFFFFFU;

bool may_meet(const SoftBody& body) {
    return body.there && !body.rigid && body.material.collides;
}

bool stirs(const SoftBody& body) {
    return body.there && !body.rigid && !body.asleep;
}

Aabb swept_box(const SoftBody& body, float fall, float dt) {
    float fastest = 0.0F;
    for (const Row4& v : body.v) {
        fastest = std::max(fastest, v.squaredNorm());
    }
    return body.box.grown(std::min(dt * std::sqrt(fastest) + fall, kFarthestSweep));
}

}  // namespace

void SoftPairs::find(std::span<SoftBody> bodies, const Vec3& gravity, float dt) {
    do {
        find_overlaps(bodies, gravity, dt);
        nodes_.clear();
        faces_.clear();
        for (SoftPair& pair : pairs_) {
            search(bodies, pair, gravity, dt);
        }
        std::erase_if(pairs_, [](const SoftPair& pair) { return pair.first == pair.end; });
    } while (wake_touched(bodies));
    build_islands(bodies);
}

void SoftPairs::find_overlaps(std::span<SoftBody> bodies, const Vec3& gravity, float dt) {
    pairs_.clear();
    if (std::count_if(bodies.begin(), bodies.end(), may_meet) < 2) {
        if (index_.size() > 0) {
            index_ = spatial::SortAndSweep();  // its boxes would go stale
        }
        return;
    }
    boxes_.resize(bodies.size());
    moved_.clear();
    const float fall = 0.5F * gravity.norm() * dt * dt;
    index_.reserve(bodies.size());
    for (std::uint32_t i = 0; i < bodies.size(); ++i) {
        if (!may_meet(bodies[i])) {
            if (index_.contains(i)) {
                index_.remove(i);
            }
            continue;
        }
        const bool known = index_.contains(i);
        if (!known || !bodies[i].asleep) {
            boxes_[i] = swept_box(bodies[i], fall, dt);
        }
        if (!known) {
            index_.insert(i, boxes_[i]);
        }
        if (!bodies[i].asleep) {
            moved_.push_back(i);
        }
    }
    index_.update(moved_, boxes_);
    for (const std::uint32_t i : moved_) {
        index_.query(boxes_[i], [&](std::uint32_t j) {
            if (j > i || (j < i && bodies[j].asleep)) {
                pairs_.push_back({kNoIsland, std::min(i, j), std::max(i, j), 0, 0});
            }
        });
    }
    std::sort(pairs_.begin(), pairs_.end());
}

void SoftPairs::search(std::span<SoftBody> bodies, SoftPair& pair, const Vec3& gravity, float dt) {
    pair.first = static_cast<std::uint32_t>(nodes_.size());
    fit_skin(bodies[pair.a]);
    fit_skin(bodies[pair.b]);
    PairSearch search{bodies, dt, 0.5F * gravity.norm() * dt * dt, nodes_, faces_};
    search.run(pair.a, pair.b);
    search.run(pair.b, pair.a);
    pair.end = static_cast<std::uint32_t>(nodes_.size());
}

bool SoftPairs::wake_touched(std::span<SoftBody> bodies) const {
    bool woke = false;
    for (const SoftPair& pair : pairs_) {
        SoftBody& a = bodies[pair.a];
        SoftBody& b = bodies[pair.b];
        if (a.asleep == b.asleep || (a.asleep ? b : a).still_s > 0.0F) {
            continue;  // one that lies still may rest on a sleeper
        }
        SoftBody& sleeper = a.asleep ? a : b;
        sleeper.asleep = false;
        sleeper.still_s = 0.0F;
        woke = true;
    }
    return woke;
}

/// Union by the least index: the islands do not depend on the order of pairs.
void SoftPairs::build_islands(std::span<const SoftBody> bodies) {
    root_.resize(bodies.size());
    for (std::uint32_t i = 0; i < bodies.size(); ++i) {
        root_[i] = i;
    }
    const auto root_of = [&](std::uint32_t i) {
        while (root_[i] != i) {
            i = root_[i] = root_[root_[i]];
        }
        return i;
    };
    for (const SoftPair& pair : pairs_) {
        if (stirs(bodies[pair.a]) && stirs(bodies[pair.b])) {
            const std::uint32_t a = root_of(pair.a);
            const std::uint32_t b = root_of(pair.b);
            root_[std::max(a, b)] = std::min(a, b);
        }
    }
    members_.clear();
    for (std::uint32_t i = 0; i < bodies.size(); ++i) {
        root_[i] = root_of(i);
        if (stirs(bodies[i])) {
            members_.push_back(i);
        }
    }
    for (SoftPair& pair : pairs_) {
        pair.island = root_[stirs(bodies[pair.a]) ? pair.a : pair.b];
    }
    std::sort(pairs_.begin(), pairs_.end());
    std::sort(members_.begin(), members_.end(), [&](std::uint32_t a, std::uint32_t b) {
        return root_[a] != root_[b] ? root_[a] < root_[b] : a < b;
    });
    islands_.clear();
    std::uint32_t pair = 0;
    for (std::uint32_t i = 0; i < members_.size();) {
        SoftIsland island{i, i, pair, pair, 0.0F, 0.0F};
        const std::uint32_t root = root_[members_[i]];
        for (; i < members_.size() && root_[members_[i]] == root; ++i) {
            island.end_member = i + 1;
        }
        for (; pair < pairs_.size() && pairs_[pair].island == root; ++pair) {
            island.end_pair = pair + 1;
        }
        islands_.push_back(island);
    }
    for (SoftIsland& island : islands_) {
        rate_island(bodies, island);
    }
}

/// How fast nodes come to the faces that they may meet, and how near they may come.
void SoftPairs::rate_island(std::span<const SoftBody> bodies, SoftIsland& island) const {
    island.least = INFINITY;
    for (std::uint32_t p = island.first_pair; p < island.end_pair; ++p) {
        const SoftPair& pair = pairs_[p];
        island.least = std::min(
            island.least, bodies[pair.a].material.thickness + bodies[pair.b].material.thickness);
        for (std::uint32_t n = pair.first; n < pair.end; ++n) {
            const SkinNode& at = nodes_[n];
            const SoftBody& other = bodies[at.other];
            const Vec3 v = bodies[at.body].v[at.node].head<3>();
            for (std::uint32_t k = at.first; k < at.end; ++k) {
                const std::uint32_t corner = other.skin.faces[faces_[k].face][0];
                island.fastest =
                    std::max(island.fastest, (v - other.v[corner].head<3>()).squaredNorm());
            }
        }
    }
    island.fastest = std::sqrt(island.fastest);
}

int SoftPairs::substeps(const SoftIsland& island, float dt) const {
    const float least = std::ceil(dt * island.fastest / island.least);
    return static_cast<int>(std::clamp(least, 1.0F, static_cast<float>(kMostContactSubsteps)));
}

std::uint32_t SoftPairs::solve(std::span<SoftBody> bodies,
                               const SoftIsland& island,
                               float h) const {
    std::uint32_t held = 0;
    for (std::uint32_t p = island.first_pair; p < island.end_pair; ++p) {
        for (std::uint32_t n = pairs_[p].first; n < pairs_[p].end; ++n) {
            const SkinNode& at = nodes_[n];
            held += hold_off(bodies, at, std::span(faces_).subspan(at.first, at.end - at.first), h)
                        ? 1U
                        : 0U;
        }
    }
    return held;
}

}  // namespace zoned::physics::soft

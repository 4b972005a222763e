// build: hot loops
#include "server/compute/stages/particle_stage.h"

#include <algorithm>
#include <cstring>

namespace zoned::compute {

namespace {

using kernels::kLanes;
using kernels::Lanes;
using kernels::ParticleMotion;

/// Particles of a block: 192 KiB of columns, which stay in a core's cache, and some microseconds.
constexpr std::size_t kParticleBlock = 8192;
/// Columns do not begin at the same place of a page, or they would fight for the same places in the
/// cache.
constexpr std::size_t kSkew = 80;

template <int kAir, bool kCollide>
void move_range(ParticleColumns& columns,
                std::size_t begin,
                std::size_t end,
                const ParticleScene& scene) {
    float* const x = columns.column(ParticleColumns::kX);
    const std::size_t stride = columns.stride();
    const kernels::ParticleWorld world = scene.world;  // that nothing stored can alias
    const float* const gusts = scene.gusts.data();
    const float* const heights = scene.heights.data();
    for (std::size_t i = begin; i < end; i += kLanes) {
        float* const at = x + i;
        ParticleMotion<Lanes> m{kernels::zk_load(at),
                                kernels::zk_load(at + stride),
                                kernels::zk_load(at + 2 * stride),
                                kernels::zk_load(at + 3 * stride),
                                kernels::zk_load(at + 4 * stride),
                                kernels::zk_load(at + 5 * stride)};
        const Lanes from_x = m.x;
        const Lanes from_y = m.y;
        const Lanes from_z = m.z;
        kernels::particle_fly(&m, &world, gusts, kAir);
        if constexpr (kCollide) {
            kernels::particle_collide(&m, &world, heights, from_x, from_y, from_z);
        }
        kernels::zk_store(at, m.x);
        kernels::zk_store(at + stride, m.y);
        kernels::zk_store(at + 2 * stride, m.z);
        kernels::zk_store(at + 3 * stride, m.vx);
        kernels::zk_store(at + 4 * stride, m.vy);
        kernels::zk_store(at + 5 * stride, m.vz);
    }
}

}  // namespace

void ParticleColumns::reserve(std::size_t particles) {
    if (particles <= capacity_) {
        return;
    }
    const std::size_t capacity = (particles + kRoom - 1) / kRoom * kRoom;
    const std::size_t stride = capacity + kSkew;
    auto block = std::make_shared<HostBlock>(kColumns * stride * sizeof(float));
    for (std::size_t c = 0; c < kColumns && capacity_ > 0; ++c) {
        std::memcpy(block->as<float>() + c * stride, column(c), capacity_ * sizeof(float));
    }
    block_ = std::move(block);
    capacity_ = capacity;
    stride_ = stride;
}

int ParticleScene::air() const {
    if (!gusts.empty()) {
        return kernels::ZK_AIR_GUSTS;
    }
    const bool drags = world.linear_drag > 0.0F || world.quadratic_drag > 0.0F;
    return drags ? kernels::ZK_AIR_STEADY : kernels::ZK_AIR_NONE;
}

bool ParticleScene::collides() const {
    return world.planes > 0 || world.spheres > 0 || world.field.columns > 0;
}

void step_particle_range(ParticleColumns& columns,
                         std::size_t begin,
                         std::size_t end,
                         const ParticleScene& scene) {
    using Move = void (*)(ParticleColumns&, std::size_t, std::size_t, const ParticleScene&);
    static constexpr Move kMoves[3][2] = {
        {move_range<kernels::ZK_AIR_NONE, false>, move_range<kernels::ZK_AIR_NONE, true>},
        {move_range<kernels::ZK_AIR_STEADY, false>, move_range<kernels::ZK_AIR_STEADY, true>},
        {move_range<kernels::ZK_AIR_GUSTS, false>, move_range<kernels::ZK_AIR_GUSTS, true>}};
    kMoves[scene.air()][scene.collides() ? 1 : 0](columns, begin, end, scene);
}

void step_particles(ParticleColumns& columns,
                    std::size_t count,
                    const ParticleScene& scene,
                    Team& team) {
    const std::size_t whole = (count + kLanes - 1) / kLanes * kLanes;
    team.run(whole / kLanes, kParticleBlock / kLanes, [&](std::size_t begin, std::size_t end) {
        step_particle_range(columns, begin * kLanes, end * kLanes, scene);
    });
}

}  // namespace zoned::compute

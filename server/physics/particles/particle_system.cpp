#include "server/physics/particles/particle_system.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace zoned::physics {

namespace {

constexpr Tick kNever = std::numeric_limits<Tick>::max();

std::string unfit_walls(const ParticleSystemDef& def) {
    if (def.walls.size() > kernels::ZK_MOST_PLANES) {
        return "walls: more than " + std::to_string(static_cast<int>(kernels::ZK_MOST_PLANES));
    }
    for (const ParticleWall& wall : def.walls) {
        if (!(std::abs(wall.normal.squaredNorm() - 1.0F) < 1e-3F) || !std::isfinite(wall.offset)) {
            return "walls: normals must have length 1, offsets be finite";
        }
    }
    if (def.balls.size() > kernels::ZK_MOST_SPHERES) {
        return "balls: more than " + std::to_string(static_cast<int>(kernels::ZK_MOST_SPHERES));
    }
    for (const ParticleBall& ball : def.balls) {
        if (!(ball.radius > 0.0F) || !std::isfinite(ball.radius) || !ball.centre.allFinite()) {
            return "balls: radii must be above 0, centres finite";
        }
    }
    return {};
}

std::string unfit_numbers(const ParticleSystemDef& def) {
    const auto size = [](float value) {
        return value >= 0.0F && std::isfinite(value);
    };
    if (!def.gravity.allFinite()) {
        return "gravity: must be finite";
    }
    if (!size(def.linear_drag) || !size(def.quadratic_drag)) {
        return "linear_drag, quadratic_drag: must be finite and not below 0";
    }
    if (!size(def.radius) || !size(def.friction)) {
        return "radius, friction: must be finite and not below 0";
    }
    if (!(def.restitution >= 0.0F && def.restitution <= 1.0F)) {
        return "restitution: must be 0..1";
    }
    if (def.most == 0 || def.most > (std::size_t{1} << 28U)) {
        return "most: must be 1..2^28";
    }
    if (def.pieces < 1 || def.pieces > 64) {
        return "pieces: must be 1..64";
    }
    return {};
}

kernels::ParticleField view_of(const Heightfield& field, const Vec3& origin) {
    const Heightfield::HeightfieldTables& t = field.tables();
    const Vec3 corner = field.sample(0, 0);
    return {static_cast<int>(t.columns),
            static_cast<int>(t.rows),
            origin.x() + corner.x(),
            origin.y(),
            origin.z() + corner.z(),
            t.spacing_x,
            t.spacing_z,
            origin.y() + t.lowest - t.thickness};
}

kernels::ParticleWorld world_of(const ParticleSystemDef& def) {
    kernels::ParticleWorld w{};
    w.gx = def.gravity.x();
    w.gy = def.gravity.y();
    w.gz = def.gravity.z();
    w.linear_drag = def.linear_drag;
    w.quadratic_drag = def.quadratic_drag;
    w.wind_x = def.wind.uniform.x();
    w.wind_y = def.wind.uniform.y();
    w.wind_z = def.wind.uniform.z();
    w.gust_cells_per_m = 1.0F / def.wind.gust_size;
    w.restitution = def.restitution;
    w.friction = def.friction;
    w.radius = def.radius;
    for (const ParticleWall& wall : def.walls) {
        w.plane[w.planes++] = {wall.normal.x(), wall.normal.y(), wall.normal.z(), wall.offset};
    }
    w.spheres = static_cast<int>(def.balls.size());
    if (def.field) {
        w.field = view_of(*def.field, def.field_origin);
    }
    return w;
}

}  // namespace

std::string unfit(const ParticleSystemDef& def) {
    std::string why = unfit_numbers(def);
    if (why.empty()) {
        why = unfit_walls(def);
    }
    if (why.empty()) {
        why = unfit(def.wind);
        why = why.empty() ? why : "wind." + why;
    }
    if (why.empty() && def.flock) {
        why = unfit(*def.flock);
        why = why.empty() ? why : "flock." + why;
    }
    return why.empty() ? why : def.name + ": " + why;
}

ParticleSystem::ParticleSystem(ParticleSystemDef def, compute::Device* device)
    : def_(std::move(def)),
      stage_(def_.flock ? nullptr : device) {
    const bool drags = def_.linear_drag > 0.0F || def_.quadratic_drag > 0.0F;
    if (drags) {
        gusts_ = gust_table(def_.wind);
    }
    scene_.world = world_of(def_);
    scene_.gusts = gusts_;
    if (def_.field) {
        scene_.heights = def_.field->tables().heights;
    }
    move_balls(def_.balls);
    if (def_.flock) {
        flock_ = std::make_unique<Flock>(*def_.flock, device);
    }
}

void ParticleSystem::use_device(compute::Device* device) {
    if (flock_) {
        flock_->use_device(device);
    } else {
        stage_ = compute::ParticleStage(device);
    }
}

std::uint32_t ParticleSystem::add(const motion::Emitter& emitter) {
    emitters_.push_back(emitter);
    return static_cast<std::uint32_t>(emitters_.size() - 1);
}

void ParticleSystem::forget_over(Tick now, float h) {
    std::erase_if(emitters_, [&](const motion::Emitter& e) {
        return motion::born_before(e, now, static_cast<double>(h)) == e.most;
    });
}

void ParticleSystem::move_balls(std::span<const ParticleBall> balls) {
    const std::size_t count =
        std::min(balls.size(), static_cast<std::size_t>(scene_.world.spheres));
    for (std::size_t i = 0; i < count; ++i) {
        const ParticleBall& ball = balls[i];
        scene_.world.sphere[i] = {ball.centre.x(), ball.centre.y(), ball.centre.z(), ball.radius};
    }
}

void ParticleSystem::remove(std::size_t i) {
    const std::size_t last = --size_;
    for (std::size_t c = 0; c < compute::ParticleColumns::kColumns; ++c) {
        columns_.column(c)[i] = columns_.column(c)[last];
        columns_.column(c)[last] = 0.0F;
    }
    ends_[i] = ends_[last];
    ends_.pop_back();
}

/// From the back, so that a particle that fills a gap was looked at already, or lies in a later
/// block that was.
void ParticleSystem::bury_block(std::size_t block, Tick now, ParticleCounts& counts) {
    const std::size_t begin = block * kBlock;
    for (std::size_t i = std::min(begin + kBlock, size_); i > begin; --i) {
        if (ends_[i - 1] <= now) {
            remove(i - 1);
            ++counts.died;
        }
    }
    Tick first = kNever;
    for (std::size_t i = begin; i < std::min(begin + kBlock, size_); ++i) {
        first = std::min(first, ends_[i]);
    }
    block_ends_[block] = first;
}

/// Blocks in which nobody dies are not looked into.
void ParticleSystem::bury(Tick now, ParticleCounts& counts) {
    for (std::size_t block = block_ends_.size(); block > 0; --block) {
        if (block_ends_[block - 1] <= now) {
            bury_block(block - 1, now, counts);
        }
    }
    block_ends_.resize((size_ + kBlock - 1) / kBlock);
}

void ParticleSystem::put(const motion::Birth& birth, Tick now, double h, double since_start_s) {
    // It is as if it had been there when the step began, flying without forces.
    const auto early = static_cast<float>(std::clamp(birth.at_s - since_start_s, 0.0, h));
    const Vec3 at = birth.position - early * birth.velocity;
    const float values[] = {
        at.x(), at.y(), at.z(), birth.velocity.x(), birth.velocity.y(), birth.velocity.z()};
    for (std::size_t c = 0; c < compute::ParticleColumns::kColumns; ++c) {
        columns_.column(c)[size_] = values[c];
    }
    const double steps =
        std::ceil((static_cast<double>(birth.lifetime_s) + static_cast<double>(early)) / h);
    const Tick end = now + std::max<Tick>(1, static_cast<Tick>(std::min(steps, 1e15)));
    ends_.push_back(end);
    const std::size_t block = size_ / kBlock;
    if (block == block_ends_.size()) {
        block_ends_.push_back(kNever);
    }
    block_ends_[block] = std::min(block_ends_[block], end);
    ++size_;
}

void ParticleSystem::give_birth(Tick now, float h, ParticleCounts& counts) {
    const auto tick_s = static_cast<double>(h);
    for (const motion::Emitter& emitter : emitters_) {
        const std::uint64_t begin = motion::born_before(emitter, now, tick_s);
        const std::uint64_t end = motion::born_before(emitter, now + 1, tick_s);
        const std::uint64_t room = std::min<std::uint64_t>(end - begin, def_.most - size_);
        if (room > 0) {
            columns_.reserve(std::min(def_.most, std::max(size_ + room, 2 * columns_.capacity())));
        }
        const double since = static_cast<double>(now - emitter.start) * tick_s;
        for (std::uint64_t i = begin; i < begin + room; ++i) {
            put(motion::birth_of(emitter, i), now, tick_s, since);
        }
        counts.born += room;
        counts.refused += end - begin - room;
    }
}

void ParticleSystem::update_world(double time_s, float h) {
    scene_.world.h = h;
    if (!gusts_.empty()) {
        const Vec3 origin = gust_origin(def_.wind, time_s);
        scene_.world.gust_x = origin.x();
        scene_.world.gust_y = origin.y();
        scene_.world.gust_z = origin.z();
    }
}

compute::StageRun ParticleSystem::step(Tick now,
                                       float h,
                                       bool on_device,
                                       compute::Team& team,
                                       ParticleCounts& counts) {
    bury(now, counts);
    give_birth(now, h, counts);
    return flock_ ? flock_->step(columns_, size_, h, on_device, team)
                  : fly(now, h, on_device, team);
}

compute::StageRun ParticleSystem::fly(Tick now, float h, bool on_device, compute::Team& team) {
    const float piece = h / static_cast<float>(def_.pieces);
    compute::StageRun all;
    for (int i = 0; i < def_.pieces; ++i) {
        update_world(static_cast<double>(now) * static_cast<double>(h) +
                         static_cast<double>(i) * static_cast<double>(piece),
                     piece);
        compute::StageRun run =
            (on_device ? stage_ : cpu_stage_).step(columns_, size_, scene_, team);
        all.on_device = all.on_device || run.on_device;
        if (!run.fault.empty()) {
            all.fault = std::move(run.fault);
        }
    }
    return all;
}

bool ParticleSystem::keeps_threads_busy() const {
    // Some 20 us of one thread: measured 0.4 ns a particle in vacuum, 5 and more with gusts or
    // something to hit, 100 in a flock.
    if (flock_) {
        return size_ > 256U;
    }
    const bool dear = scene_.collides() || scene_.air() == kernels::ZK_AIR_GUSTS;
    return size_ > (dear ? 4096U : 49'152U);
}

Vec3 ParticleSystem::position(std::size_t i) const {
    return {columns_.column(0)[i], columns_.column(1)[i], columns_.column(2)[i]};
}

Vec3 ParticleSystem::velocity(std::size_t i) const {
    return {columns_.column(3)[i], columns_.column(4)[i], columns_.column(5)[i]};
}

bool ParticleSystem::is_over(Tick now, float h) const {
    return size_ == 0 && std::all_of(emitters_.begin(), emitters_.end(), [&](const auto& e) {
               return motion::born_before(e, now, static_cast<double>(h)) == e.most;
           });
}

}  // namespace zoned::physics

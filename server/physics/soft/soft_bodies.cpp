#include "server/physics/soft/soft_bodies.h"

#include "server/compute/team.h"
#include "server/physics/scene/scene.h"
#include "server/physics/shapes/compound/body_checks.h"
#include "server/physics/shapes/ranges.h"
#include "server/physics/soft/soft_impl.h"
#include "server/physics/soft/volume.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace zoned::physics::soft {

namespace {

/// Bodies with more springs are worked at by all threads, smaller ones each by one.
constexpr std::size_t kLargeBody = 4096;

/// NaN anywhere shows in the sum; so does a number that is too large.
bool is_fit(const SoftBody& body) {
    Row4 x = Row4::Zero();
    Row4 v = Row4::Zero();
    for (std::size_t i = 0; i < body.x.size(); ++i) {
        x += body.x[i].cwiseAbs();
        v += body.v[i].cwiseAbs();
    }
    return x.head<3>().allFinite() && v.allFinite() && fit_position(body.box.lower) &&
           fit_position(body.box.upper);
}

void solve(SoftBody& body, float h, compute::Team* team) {
    switch (body.solver.method) {
        case SoftMethod::kXpbd:
            return solve_xpbd(body, h, team);
        case SoftMethod::kImplicitEuler:
            return solve_implicit(body, h);
        case SoftMethod::kSemiImplicitEuler:
            return;  // its springs have pushed before the nodes moved
    }
}

void substep(SoftBody& body, const Vec3& gravity, float h, compute::Team* team) {
    if (body.solver.method == SoftMethod::kSemiImplicitEuler) {
        push_springs(body, h);
    }
    predict(body, gravity, h);
    solve(body, h, team);
    solve_close_pairs(body);
}

/// Contacts hand on loads once a substep, whatever the method solves within the body. One that
/// stops a node of m kg at v m/s leaves its springs pressed by v h: they hold k (v h)^2 / 2, no
/// more than the m v^2 / 2 that it takes, where omega h is at most 1. Explicit springs, which give
/// all of it back, bear up to twice that.
int substeps_in_contact(const SoftBody& body, float dt) {
    const int n = body.substeps(dt);
    if (body.solver.method == SoftMethod::kSemiImplicitEuler) {
        return std::min(2 * n, kMostSubsteps);
    }
    return std::max(n, body.relaxed_substeps());
}

bool active(const SoftBody& body) {
    return body.there && !body.asleep && !body.rigid;
}

}  // namespace

void SoftBodies::Impl::wake_touched(const Scene& scene, float slow, float dt) {
    for (SoftBody& body : bodies) {
        if (!body.there || !body.asleep || body.rigid || !body.material.collides) {
            continue;
        }
        body.neighbours.clear();
        scene.overlap(body.box.grown(dt * kFastBody), body.neighbours);
        body.asleep = std::none_of(body.neighbours.begin(), body.neighbours.end(), [&](BodyId id) {
            const BodyState s = scene.state(id);
            const float speed = s.velocity.norm() + s.angular_velocity.norm();
            if (s.asleep || !(speed > slow)) {
                return false;
            }
            near.clear();
            scene.overlap(body.box.grown(2.0F * dt * speed), near);
            return std::find(near.begin(), near.end(), id) != near.end();
        });
        body.still_s = body.asleep ? body.still_s : 0.0F;
    }
}

void SoftBodies::Impl::integrate_island(const SoftIsland& island,
                                        const Vec3& gravity,
                                        float dt,
                                        Scene* scene,
                                        compute::Team* helpers) {
    const std::span<const std::uint32_t> members = pairs.members(island);
    const bool meets = island.first_pair < island.end_pair;
    int n = meets ? pairs.substeps(island, dt) : 1;
    for (const std::uint32_t i : members) {
        const bool touches = meets || !bodies[i].contacts.empty();
        n = std::max(n, touches ? substeps_in_contact(bodies[i], dt) : bodies[i].substeps(dt));
    }
    const float h = dt / static_cast<float>(n);
    for (int step = 0; step < n; ++step) {
        for (const std::uint32_t i : members) {
            substep(bodies[i], gravity, h, helpers);
        }
        bodies[members.front()].held = meets ? pairs.solve(bodies, island, h) : 0;
        for (const std::uint32_t i : members) {
            if (!bodies[i].contacts.empty()) {
                solve_contacts(bodies[i], *scene, h);
            }
            finish(bodies[i], h);
        }
    }
    for (const std::uint32_t i : members) {
        bodies[i].substeps_done = static_cast<std::uint32_t>(n);
    }
}

void SoftBodies::Impl::integrate(const Vec3& gravity, float dt, Scene* scene, compute::Team* team) {
    std::optional<compute::Team::Shift> shift;
    if (team != nullptr) {
        shift.emplace(*team);
    }
    const std::span<const SoftIsland> islands = pairs.islands();
    // Bodies that push rigid ones go one by one: the order of impulses matters.
    const auto alone = [&](const SoftIsland& island) {
        const std::span<const std::uint32_t> members = pairs.members(island);
        return std::any_of(members.begin(), members.end(), [&](std::uint32_t i) {
            return bodies[i].springs.size() > kLargeBody || !bodies[i].contacts.empty();
        });
    };
    const auto run_small = [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (!alone(islands[i])) {
                integrate_island(islands[i], gravity, dt, scene, nullptr);
            }
        }
    };
    if (team != nullptr) {
        team->run(islands.size(), 1, run_small);
    } else {
        run_small(0, islands.size());
    }
    for (const SoftIsland& island : islands) {
        if (alone(island)) {
            integrate_island(island, gravity, dt, scene, team);
        }
    }
}

/// After the substeps: tears, sets, quarantines, puts to sleep.
void SoftBodies::Impl::settle(SoftBody& body, const SoftSettings& settings, float dt) {
    fit_box(body);
    if (!is_fit(body)) {
        body.x = body.kept;
        std::fill(body.v.begin(), body.v.end(), Row4::Zero());
        fit_box(body);
        body.asleep = true;
        ++stats.quarantined;
        return;
    }
    const bool crept = creep(body, dt);
    const std::uint32_t torn = tear(body);
    stats.torn += torn;
    if (crept && torn == 0) {
        body.batches.refresh(body.springs);
    }
    stats.contacts += static_cast<std::uint32_t>(body.contacts.size()) + body.held;
    // By the distance of the step: where springs hold weight, the velocity at the end of a substep
    // is g h / 2 (half of gravity's share), though nothing moves.
    float farthest = 0.0F;
    for (std::size_t i = 0; i < body.kept.size(); ++i) {
        farthest = std::max(farthest, (body.x[i] - body.kept[i]).head<3>().squaredNorm());
    }
    const bool calm =
        std::sqrt(farthest) < settings.sleep_speed_mps * dt && torn == 0 && !body.touches_dynamic;
    body.still_s = calm ? body.still_s + dt : 0.0F;
}

void SoftBodies::Impl::put_to_sleep(const SoftSettings& settings) {
    if (!(settings.sleep_after_s > 0.0F)) {
        return;
    }
    for (const SoftIsland& island : pairs.islands()) {
        const std::span<const std::uint32_t> members = pairs.members(island);
        const bool still = std::all_of(members.begin(), members.end(), [&](std::uint32_t i) {
            return bodies[i].asleep || bodies[i].still_s >= settings.sleep_after_s;
        });
        for (const std::uint32_t i : members) {
            if (still && !bodies[i].asleep) {
                bodies[i].asleep = true;
                std::fill(bodies[i].v.begin(), bodies[i].v.end(), Row4::Zero());
            }
        }
    }
}

void SoftBodies::Impl::wake_around(const SoftBody& gone) {
    for (SoftBody& body : bodies) {
        if (&body != &gone && body.there && body.asleep && body.box.overlaps(gone.box)) {
            body.asleep = false;
            body.still_s = 0.0F;
        }
    }
}

void SoftBodies::Impl::count(SoftStats& s) const {
    for (const SoftBody& body : bodies) {
        if (body.there) {
            ++s.bodies;
            s.rigid += body.rigid ? 1 : 0;
        }
        if (active(body)) {
            ++s.awake;
            s.nodes += static_cast<std::uint32_t>(body.x.size());
            s.springs += static_cast<std::uint32_t>(body.springs.size());
            s.substeps += body.substeps_done;
            s.newton_steps += body.implicit.newton_steps;
            s.gradient_passes += body.implicit.gradient_passes;
        }
    }
}

SoftBodies::SoftBodies(const SoftSettings& settings) : settings_(settings) {
}

SoftBodies::SoftBodies(SoftBodies&&) noexcept = default;
SoftBodies& SoftBodies::operator=(SoftBodies&&) noexcept = default;
SoftBodies::~SoftBodies() = default;

core::Result<SoftId> SoftBodies::add(const SoftDef& def) {
    using R = core::Result<SoftId>;
    std::string reason = why_unfit(def);
    if (reason.empty()) {
        reason = why_unstable(def, settings_.step_s);
    }
    if (!reason.empty()) {
        return R::failure(std::move(reason));
    }
    if (impl_ == nullptr) {
        impl_ = std::make_unique<Impl>();
    }
    impl_->bodies.push_back(make_body(def));
    return SoftId(retired_ + static_cast<std::uint32_t>(impl_->bodies.size()));
}

void SoftBodies::remove(SoftId id) {
    if (!contains(id)) {
        return;
    }
    impl_->wake_around(impl_->bodies[id.value - 1 - retired_]);
    impl_->bodies[id.value - 1 - retired_] = SoftBody();
    if (empty()) {
        retired_ += static_cast<std::uint32_t>(impl_->bodies.size());
        impl_.reset();
    }
}

bool SoftBodies::contains(SoftId id) const {
    return impl_ != nullptr && id.value > retired_ && id.value - retired_ <= impl_->bodies.size() &&
           impl_->bodies[id.value - 1 - retired_].there;
}

bool SoftBodies::empty() const {
    return impl_ == nullptr || std::none_of(impl_->bodies.begin(),
                                            impl_->bodies.end(),
                                            [](const SoftBody& b) { return b.there; });
}

void SoftBodies::work_with(compute::Team* team) {
    team_ = team;
}

SoftStats SoftBodies::step(float dt, Scene* scene) {
    SoftStats none;
    none.skipped = true;
    if (impl_ == nullptr || !(dt > 0.0F) || !std::isfinite(dt)) {
        return none;
    }
    if (scene != nullptr) {
        impl_->wake_touched(*scene, settings_.sleep_speed_mps, dt);
    }
    impl_->stats = SoftStats();
    if (std::none_of(impl_->bodies.begin(), impl_->bodies.end(), active)) {
        impl_->count(impl_->stats);
        impl_->stats.skipped = true;
        return impl_->stats;
    }
    impl_->pairs.find(impl_->bodies, settings_.gravity, dt);
    for (SoftBody& body : impl_->bodies) {
        if (active(body)) {
            body.kept = body.x;
            body.contacts.clear();
            body.held = 0;
            body.implicit.newton_steps = 0;
            body.implicit.gradient_passes = 0;
            if (scene != nullptr) {
                find_contacts(body, *scene, dt);
            }
            find_close_pairs(body);
            if (body.gas > 0.0 || body.material.bulk_modulus > 0.0F) {
                limit_step(body);  // a pressed body is stiffer
            }
        }
    }
    impl_->integrate(settings_.gravity, dt, scene, team_);
    for (SoftBody& body : impl_->bodies) {
        if (active(body)) {
            impl_->settle(body, settings_, dt);
        }
    }
    impl_->put_to_sleep(settings_);
    impl_->count(impl_->stats);
    return impl_->stats;
}

SoftStats SoftBodies::stats() const {
    return impl_ == nullptr ? SoftStats() : impl_->stats;
}

void SoftBodies::hash(core::StateHash& hash) const {
    if (impl_ == nullptr) {
        return;
    }
    hash.add(impl_->bodies.size());
    for (const SoftBody& body : impl_->bodies) {
        hash.add(std::uint64_t{body.there} | std::uint64_t{body.asleep} << 1U |
                 std::uint64_t{body.rigid} << 2U);
        hash.add(body.still_s);
        hash.add(body.x.size());
        for (std::size_t i = 0; i < body.x.size(); ++i) {
            for (int k = 0; k < 4; ++k) {
                hash.add(body.x[i][k]);
            }
            for (int k = 0; k < 3; ++k) {
                hash.add(body.v[i][k]);
            }
        }
        for (const Spring& s : body.springs) {
            hash.add(std::uint64_t{s.a} << 32U | s.b);
            hash.add(s.rest);
        }
    }
}

#define ZONED_SOFT_BODY(id)                                      \
    ZONED_ASSERT(contains(id), "a soft body that is not there"); \
    SoftBody& body = impl_->bodies[(id).value - 1 - retired_]

std::uint32_t SoftBodies::user(SoftId id) const {
    ZONED_SOFT_BODY(id);
    return body.user;
}

std::size_t SoftBodies::node_count(SoftId id) const {
    ZONED_SOFT_BODY(id);
    return body.x.size();
}

Vec3 SoftBodies::position(SoftId id, std::size_t node) const {
    ZONED_SOFT_BODY(id);
    return body.position(node);
}

Vec3 SoftBodies::velocity(SoftId id, std::size_t node) const {
    ZONED_SOFT_BODY(id);
    return body.v[node].head<3>();
}

float SoftBodies::mass(SoftId id, std::size_t node) const {
    ZONED_SOFT_BODY(id);
    return body.mass[node];
}

std::span<const SoftFace> SoftBodies::faces(SoftId id) const {
    ZONED_SOFT_BODY(id);
    return body.faces;
}

std::size_t SoftBodies::spring_count(SoftId id) const {
    ZONED_SOFT_BODY(id);
    return body.springs.size();
}

std::uint32_t SoftBodies::torn(SoftId id) const {
    ZONED_SOFT_BODY(id);
    return body.torn;
}

std::size_t SoftBodies::vertex_count(SoftId id) const {
    ZONED_SOFT_BODY(id);
    return body.vertices.empty() ? body.x.size() : body.vertices.size();
}

std::size_t SoftBodies::vertices(SoftId id, std::span<Vec3> out) const {
    ZONED_SOFT_BODY(id);
    const std::size_t count = std::min(out.size(), vertex_count(id));
    for (std::size_t i = 0; i < count; ++i) {
        if (body.vertices.empty()) {
            out[i] = body.position(i);
            continue;
        }
        const SoftVertex& v = body.vertices[i];
        Row4 sum = Row4::Zero();
        for (std::size_t k = 0; k < 4; ++k) {
            sum += v.weight[k] * body.x[v.node[k]];
        }
        out[i] = sum.head<3>();
        if (v.offset != 0.0F) {
            const Vec3 a = body.position(v.node[0]);
            out[i] +=
                v.offset *
                (body.position(v.node[1]) - a).cross(body.position(v.node[2]) - a).normalized();
        }
    }
    return count;
}

std::span<const SoftVertex> SoftBodies::hung_vertices(SoftId id) const {
    ZONED_SOFT_BODY(id);
    return body.vertices;
}

std::span<const SoftFace> SoftBodies::drawn_faces(SoftId id) const {
    ZONED_SOFT_BODY(id);
    if (!body.vertices.empty()) {
        return body.drawn_faces;
    }
    return body.faces.empty() ? body.skin.faces : body.faces;
}

Aabb SoftBodies::bounds(SoftId id) const {
    ZONED_SOFT_BODY(id);
    return body.box;
}

bool SoftBodies::asleep(SoftId id) const {
    ZONED_SOFT_BODY(id);
    return body.asleep;
}

double SoftBodies::volume(SoftId id) const {
    ZONED_SOFT_BODY(id);
    return enclosed_volume(body, nullptr);
}

double SoftBodies::energy(SoftId id) const {
    ZONED_SOFT_BODY(id);
    return energy_of(body, settings_.gravity);
}

void SoftBodies::apply_impulse(SoftId id, std::size_t node, const Vec3& impulse) {
    ZONED_SOFT_BODY(id);
    if (impulse.allFinite() && body.x[node].w() > 0.0F) {
        body.v[node].head<3>() += body.x[node].w() * impulse;
        wake(id);
    }
}

void SoftBodies::lead(SoftId id, std::size_t node, const Vec3& velocity) {
    ZONED_SOFT_BODY(id);
    if (fit_velocity(velocity, Vec3::Zero()) && body.x[node].w() == 0.0F) {
        body.v[node].head<3>() = velocity;
        wake(id);
    }
}

void SoftBodies::pin(SoftId id, std::size_t node, bool pinned) {
    ZONED_SOFT_BODY(id);
    if (pinned) {
        body.v[node].setZero();
    }
    body.x[node].w() = pinned ? 0.0F : 1.0F / body.mass[node];
    limit_step(body);
    wake(id);
}

void SoftBodies::move_node(SoftId id, std::size_t node, const Vec3& position) {
    ZONED_SOFT_BODY(id);
    if (fit_position(position)) {
        body.x[node].head<3>() = position;
        fit_box(body);
        wake(id);
    }
}

void SoftBodies::wake(SoftId id) {
    ZONED_SOFT_BODY(id);
    body.asleep = false;
    body.still_s = 0.0F;
}

RigidHull SoftBodies::rigid_hull(SoftId id) const {
    ZONED_SOFT_BODY(id);
    return rigid_hull_of(body);
}

RigidHull SoftBodies::step_down(SoftId id) {
    ZONED_SOFT_BODY(id);
    body.rigid = true;
    return rigid_hull_of(body);
}

void SoftBodies::step_up(SoftId id,
                         const Vec3& position,
                         const Quat& turn,
                         const Vec3& velocity,
                         const Vec3& angular_velocity) {
    ZONED_SOFT_BODY(id);
    if (!body.rigid || !fit_position(position) || !fit_orientation(turn) ||
        !fit_velocity(velocity, angular_velocity)) {
        return;
    }
    place_rigid(body, rigid_hull_of(body), position, turn, velocity, angular_velocity);
    body.rigid = false;
    fit_box(body);
    wake(id);
}

#undef ZONED_SOFT_BODY

}  // namespace zoned::physics::soft

#include "server/compute/worker_pool.h"
#include "server/physics/scene.h"
#include "tests/bench/simulator.h"

#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace zoned::bench {

namespace {

physics::Shape shape_of(const scenario::Solid& solid) {
    switch (solid.form) {
        case scenario::Form::kSphere:
            return physics::Shape::sphere(static_cast<float>(solid.radius));
        case scenario::Form::kBox:
            return physics::Shape::box(solid.half_extents.cast<float>());
        case scenario::Form::kCapsule:
            return physics::Shape::capsule(static_cast<float>(solid.radius),
                                           static_cast<float>(solid.half_segment));
    }
    throw std::logic_error("a solid of no form");
}

physics::BodyDef definition(const scenario::Body& body) {
    physics::BodyDef def;
    def.kind = body.mass > 0.0 ? physics::BodyKind::kDynamic : physics::BodyKind::kStatic;
    def.shape = shape_of(body.solid);
    def.material.friction = static_cast<float>(body.friction);
    def.material.restitution = static_cast<float>(body.restitution);
    def.mass = static_cast<float>(body.mass > 0.0 ? body.mass : 1.0);
    def.position = body.pose.position.cast<float>();
    def.orientation = body.pose.orientation.cast<float>();
    def.velocity = body.velocity.cast<float>();
    def.angular_velocity = body.spin.cast<float>();
    return def;
}

class ZonedSimulator : public Simulator {
  public:
    ZonedSimulator(const scenario::Description& description,
                   physics::Settings settings,
                   unsigned threads)
        : pool_(threads),
          scene_(with_description(settings, description)),
          dt_(static_cast<float>(description.dt)) {
        team_.join_pool(pool_);
        scene_.work_with(&team_);
        for (const scenario::Body& body : description.bodies) {
            physics::BodyDef def = definition(body);
            def.filter.mask = description.colliding ? def.filter.mask : 0;
            auto id = scene_.add(def);
            if (!id) {
                throw std::runtime_error("our engine refused a body: " + id.error());
            }
            ids_.push_back(*id);
        }
        for (const scenario::BallJoint& joint : description.joints) {
            physics::JointDef def;
            def.a = joint.a == scenario::kWorld ? zoned::BodyId()
                                                : ids_[static_cast<std::size_t>(joint.a)];
            def.b = ids_[static_cast<std::size_t>(joint.b)];
            def.anchor = joint.anchor.cast<float>();
            auto id = scene_.add_joint(def);
            if (!id) {
                throw std::runtime_error("our engine refused a joint: " + id.error());
            }
        }
    }

    void step() override { scene_.step(dt_); }

    [[nodiscard]] Motion motion(std::size_t body) const override {
        const physics::BodyState state = scene_.state(ids_[body]);
        Motion m;
        m.pose.position = state.position.cast<double>();
        m.pose.orientation = state.orientation.cast<double>();
        m.velocity = state.velocity.cast<double>();
        m.spin = state.angular_velocity.cast<double>();
        return m;
    }

    bool cast(std::span<const scenario::Ray> rays, std::span<double> distances) const override {
        for (std::size_t i = 0; i < rays.size(); ++i) {
            physics::RayHit hit;
            const bool found = scene_.ray_cast(rays[i].origin.cast<float>(),
                                               rays[i].direction.cast<float>(),
                                               static_cast<float>(rays[i].length),
                                               0,
                                               hit);
            distances[i] = found ? static_cast<double>(hit.distance) : INFINITY;
        }
        return true;
    }

    [[nodiscard]] std::string state_hash() const override {
        core::StateHash hash;
        scene_.hash(hash);
        char text[17];
        std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(hash.value()));
        return text;
    }

  private:
    static physics::Settings with_description(physics::Settings settings,
                                              const scenario::Description& description) {
        settings.gravity = description.gravity.cast<float>();
        if (!description.sleeping) {
            settings.sleep_after_s = 0.0F;
        }
        return settings;
    }

    compute::WorkerPool pool_;
    compute::Team team_;
    physics::Scene scene_;
    std::vector<zoned::BodyId> ids_;
    float dt_;
};

/// Scenes up to this size are run with fixed numbers of substeps too.
constexpr std::size_t kSmall = 300;

Engine engine(std::string method, const physics::Settings& settings, unsigned threads = 1) {
    return {std::move(method),
            "",
            [settings, threads](const scenario::Description& description) {
                return std::make_unique<ZonedSimulator>(description, settings, threads);
            },
            [settings](const std::string& /*scene*/, const scenario::Description& description) {
                const bool large = settings.substeps != 0 && description.bodies.size() > kSmall;
                return std::string(large ? "only for small scenes" : "");
            }};
}

}  // namespace

std::vector<Engine> zoned_engines() {
    physics::Settings strict;
    strict.error_budget_m = 0.002F;
    std::vector<Engine> engines{engine("default", physics::Settings()),
                                engine("budget_2mm", strict),
                                engine("threads_2", physics::Settings(), 2)};
    for (const int substeps : {2, 4, 8, 16}) {
        physics::Settings fixed;
        fixed.substeps = substeps;
        engines.push_back(engine("substeps_" + std::to_string(substeps), fixed));
    }
    return engines;
}

}  // namespace zoned::bench

#include "server/compute/worker_pool.h"
#include "server/physics/scene/scene.h"
#include "tests/determinism/hashes.h"
#include "tests/scenario/elementary_bits.h"
#include "tests/scenario/physics_scenes.h"

#include <stdexcept>

namespace zoned::determinism {

namespace {

physics::Shape shape_of(const scenario::Solid& solid) {
    if (solid.form == scenario::Form::kBox) {
        return physics::Shape::box(solid.half_extents.cast<float>());
    }
    const auto radius = static_cast<float>(solid.radius);
    return solid.form == scenario::Form::kSphere
               ? physics::Shape::sphere(radius)
               : physics::Shape::capsule(radius, static_cast<float>(solid.half_segment));
}

physics::Scene build(const scenario::Description& description) {
    physics::PhysicsSettings settings;
    settings.gravity = description.gravity.cast<float>();
    physics::Scene scene(settings);
    std::vector<BodyId> ids;
    for (const scenario::Body& body : description.bodies) {
        physics::BodyDef def;
        def.kind = body.mass > 0.0 ? physics::BodyKind::kDynamic : physics::BodyKind::kStatic;
        def.shape = shape_of(body.solid);
        def.material.friction = static_cast<float>(body.friction);
        def.material.restitution = static_cast<float>(body.restitution);
        def.mass = body.mass > 0.0 ? static_cast<float>(body.mass) : 1.0F;
        def.position = body.pose.position.cast<float>();
        def.orientation = body.pose.orientation.cast<float>();
        def.velocity = body.velocity.cast<float>();
        def.angular_velocity = body.spin.cast<float>();
        const auto id = scene.add(def);
        if (!id) {
            throw std::runtime_error("a scene's body is refused: " + id.error());
        }
        ids.push_back(*id);
    }
    for (const scenario::LinkedPair& joint : description.joints) {
        physics::JointDef def;
        if (joint.a != scenario::kWorld) {
            def.a = ids[static_cast<std::size_t>(joint.a)];
        }
        def.b = ids[static_cast<std::size_t>(joint.b)];
        def.anchor = joint.anchor.cast<float>();
        if (!scene.add_joint(def)) {
            throw std::runtime_error("a scene's joint is refused");
        }
    }
    return scene;
}

}  // namespace

std::vector<Line> elementary_lines() {
    std::vector<Line> lines;
    for (const scenario::ElementarySubject& subject : scenario::kElementarySubjects) {
        lines.push_back(
            {"elementary", std::string(subject.name), hex(scenario::elementary_bits(subject))});
    }
    return lines;
}

std::vector<Line> physics_lines(unsigned threads) {
    compute::WorkerPool pool(threads);
    compute::Team team;
    team.join_pool(pool);

    struct Named {
        const char* name;
        scenario::Description description;
    };

    const Named scenes[] = {{"physics/pile", scenario::pile(9)},
                            {"physics/pyramid", scenario::pyramid()},
                            {"physics/column", scenario::column(12, 5.0)},
                            {"physics/spin", scenario::spin()},
                            {"physics/chain", scenario::chain()}};
    std::vector<Line> lines;
    for (const Named& named : scenes) {
        physics::Scene scene = build(named.description);
        scene.work_with(&team);
        for (int step = 1; step <= 360; ++step) {
            scene.step(static_cast<float>(named.description.dt));
            if (step % 60 == 0) {
                core::StateHash hash;
                scene.hash(hash);
                lines.push_back({named.name, "step " + std::to_string(step), hex(hash.value())});
            }
        }
    }
    return lines;
}

}  // namespace zoned::determinism

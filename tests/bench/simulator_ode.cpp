#include "tests/bench/simulator.h"

#include <ode/ode.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdint>
#include <numbers>
#include <stdexcept>

namespace zoned::bench {

namespace {

/// Most contact points of a pair.
constexpr int kContacts = 8;

/// ODE's library is started once for the program.
void start_library() {
    static const bool started = [] {
        dInitODE2(0);
        dAllocateODEDataForThread(dAllocateMaskAll);
        // The exact solver reports near-singular systems on every step of some scenes; their effect
        // shows in the row's error.
        dSetMessageHandler([](int, const char*, va_list) {});
        return true;
    }();
    if (!started) {
        throw std::runtime_error("ODE did not start");
    }
}

std::array<dReal, 4> quaternion(const scenario::Quatd& q) {
    return {q.w(), q.x(), q.y(), q.z()};
}

/// Turns ODE's capsule, which lies along z, to lie along y.
scenario::Quatd capsule_turn() {
    return scenario::Quatd(Eigen::AngleAxisd(-0.5 * std::numbers::pi, Vec3d::UnitX()));
}

/// Level ground as a plane: there ODE's exact solver holds stacks that fall on a large box.
dGeomID plane_of_top(dSpaceID space, const scenario::Body& body) {
    const Vec3d normal = body.pose.orientation * Vec3d::UnitY();
    const double height = normal.dot(body.pose.position) + body.solid.half_extents.y();
    return dCreatePlane(space, normal.x(), normal.y(), normal.z(), height);
}

dGeomID geometry(dSpaceID space, const scenario::Solid& solid) {
    switch (solid.form) {
        case scenario::Form::kSphere:
            return dCreateSphere(space, solid.radius);
        case scenario::Form::kBox: {
            const Vec3d size = 2.0 * solid.half_extents;
            return dCreateBox(space, size.x(), size.y(), size.z());
        }
        case scenario::Form::kCapsule:
            return dCreateCapsule(space, solid.radius, 2.0 * solid.half_segment);
        default:
            break;
    }
    throw std::logic_error("a solid of no form");
}

struct OdeSettings {
    bool exact =
        false;  ///< the direct LCP solver (dWorldStep), else 20 iterations (dWorldQuickStep)
    int substeps = 1;
};

/// ODE at its defaults.
class OdeSimulator : public Simulator {
  public:
    OdeSimulator(const scenario::Description& description, const OdeSettings& settings)
        : description_(description),
          settings_(settings) {
        start_library();
        world_ = dWorldCreate();
        space_ = dHashSpaceCreate(nullptr);
        contacts_ = dJointGroupCreate(0);
        const Vec3d& g = description.gravity;
        dWorldSetGravity(world_, g.x(), g.y(), g.z());
        dWorldSetAutoDisableFlag(world_, description.sleeping ? 1 : 0);
        for (std::size_t i = 0; i < description.bodies.size(); ++i) {
            add(i);
        }
        for (const scenario::LinkedPair& joint : description.joints) {
            const dJointID id = dJointCreateBall(world_, nullptr);
            dJointAttach(id, body_of(joint.a), body_of(joint.b));
            dJointSetBallAnchor(id, joint.anchor.x(), joint.anchor.y(), joint.anchor.z());
        }
    }

    OdeSimulator(const OdeSimulator&) = delete;
    OdeSimulator& operator=(const OdeSimulator&) = delete;

    ~OdeSimulator() override {
        dJointGroupDestroy(contacts_);
        dSpaceDestroy(space_);
        dWorldDestroy(world_);
    }

    void step() override {
        const double dt = description_.dt / settings_.substeps;
        // Its iterative solver shuffles constraints by one generator of the whole library.
        dRandSetSeed(++steps_);
        for (int i = 0; i < settings_.substeps; ++i) {
            if (description_.colliding) {
                dSpaceCollide(space_, this, [](void* self, dGeomID a, dGeomID b) {
                    static_cast<OdeSimulator*>(self)->collide(a, b);
                });
            }
            if (settings_.exact) {
                dWorldStep(world_, dt);
            } else {
                dWorldQuickStep(world_, dt);
            }
            dJointGroupEmpty(contacts_);
        }
    }

    [[nodiscard]] Motion motion(std::size_t body) const override {
        Motion m;
        const dBodyID id = bodies_[body];
        if (id == nullptr) {
            m.pose = description_.bodies[body].pose;
            return m;
        }
        const dReal* q = dBodyGetQuaternion(id);
        m.pose.orientation = scenario::Quatd(q[0], q[1], q[2], q[3]);
        m.pose.position = vector(dBodyGetPosition(id));
        m.velocity = vector(dBodyGetLinearVel(id));
        m.spin = vector(dBodyGetAngularVel(id));
        m.asleep = dBodyIsEnabled(id) == 0;
        return m;
    }

  private:
    static Vec3d vector(const dReal* v) { return {v[0], v[1], v[2]}; }

    [[nodiscard]] dBodyID body_of(int index) const {
        return index == scenario::kWorld ? nullptr : bodies_[static_cast<std::size_t>(index)];
    }

    void add(std::size_t index) {
        const scenario::Body& body = description_.bodies[index];
        if (body.ground) {
            dGeomSetData(plane_of_top(space_, body), const_cast<scenario::Body*>(&body));
            bodies_.push_back(nullptr);
            return;
        }
        const dGeomID geom = geometry(space_, body.solid);
        const bool capsule = body.solid.form == scenario::Form::kCapsule;
        dGeomSetData(geom, const_cast<scenario::Body*>(&body));
        const Vec3d& p = body.pose.position;
        if (body.mass == 0.0) {
            scenario::Quatd q = body.pose.orientation;
            if (capsule) {
                q = q * capsule_turn();
            }
            dGeomSetPosition(geom, p.x(), p.y(), p.z());
            dGeomSetQuaternion(geom, quaternion(q).data());
            bodies_.push_back(nullptr);
            return;
        }
        const dBodyID id = dBodyCreate(world_);
        dMass mass;
        const Vec3d i = body.mass * body.solid.inertia_per_mass();
        dMassSetParameters(&mass, body.mass, 0, 0, 0, i.x(), i.y(), i.z(), 0, 0, 0);
        dBodySetMass(id, &mass);
        dBodySetPosition(id, p.x(), p.y(), p.z());
        dBodySetQuaternion(id, quaternion(body.pose.orientation).data());
        dBodySetLinearVel(id, body.velocity.x(), body.velocity.y(), body.velocity.z());
        dBodySetAngularVel(id, body.spin.x(), body.spin.y(), body.spin.z());
        dGeomSetBody(geom, id);
        if (capsule) {
            dGeomSetOffsetQuaternion(geom, quaternion(capsule_turn()).data());
        }
        bodies_.push_back(id);
    }

    void collide(dGeomID a, dGeomID b) {
        const dBodyID body_a = dGeomGetBody(a);
        const dBodyID body_b = dGeomGetBody(b);
        if (body_a == nullptr && body_b == nullptr) {
            return;
        }
        std::array<dContact, kContacts> found;
        const int count = dCollide(a, b, kContacts, &found[0].geom, sizeof(dContact));
        const auto& first = *static_cast<const scenario::Body*>(dGeomGetData(a));
        const auto& second = *static_cast<const scenario::Body*>(dGeomGetData(b));
        for (int i = 0; i < count; ++i) {
            dSurfaceParameters& surface = found[static_cast<std::size_t>(i)].surface;
            surface = {};
            surface.mode = dContactApprox1;  // friction follows the normal force
            surface.mu = std::sqrt(first.friction * second.friction);
            surface.bounce = std::max(first.restitution, second.restitution);
            if (surface.bounce > 0.0) {
                surface.mode |= dContactBounce;
            }
            dJointAttach(
                dJointCreateContact(world_, contacts_, &found[static_cast<std::size_t>(i)]),
                body_a,
                body_b);
        }
    }

    scenario::Description description_;
    OdeSettings settings_;
    dWorldID world_ = nullptr;
    dSpaceID space_ = nullptr;
    dJointGroupID contacts_ = nullptr;
    std::vector<dBodyID> bodies_;  // null: static
    unsigned long steps_ = 0;
};

/// Most bodies for which a step of the exact solver, cubic in the contacts of an island, ends soon.
constexpr std::size_t kExactBodies = 100;

/// It is given solids without corners of their own, and ball joints.
bool can_run(const scenario::Description& description) {
    const auto plain = [](const scenario::Body& body) {
        return body.solid.geometry == nullptr;
    };
    const auto ball = [](const scenario::LinkedPair& joint) {
        return joint.link == scenario::Link::kBall;
    };
    return std::all_of(description.bodies.begin(), description.bodies.end(), plain) &&
           std::all_of(description.joints.begin(), description.joints.end(), ball);
}

Engine ode_engine(std::string method, const OdeSettings& settings) {
    return {std::move(method),
            "ode",
            [settings](const scenario::Description& description) {
                return std::make_unique<OdeSimulator>(description, settings);
            },
            [settings](const std::string&, const scenario::Description& description) {
                if (!can_run(description)) {
                    return std::string("it is not set up for these shapes or joints");
                }
                const bool large = settings.exact && description.bodies.size() > kExactBodies;
                return std::string(large ? "the exact solver takes too long" : "");
            }};
}

}  // namespace

std::vector<Engine> ode_engines() {
    return {ode_engine("default", {false, 1}),
            ode_engine("exact", {true, 1}),
            ode_engine("exact_substeps_4", {true, 4})};
}

}  // namespace zoned::bench

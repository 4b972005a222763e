// Contact lane: one contact of a batch as plain vectors, and what an impact gives to it.
#pragma once

#include "server/physics/solver/contact_solver.h"

#include <array>

namespace zoned::physics {

/// Points this close take part in the impact of a contact, m.
inline constexpr float kMeets = 0.0005F;

inline Row8 operator+(const Row8& a, const Row8& b) {
    return {a.at + b.at};
}

inline Row8 operator-(const Row8& a, const Row8& b) {
    return {a.at - b.at};
}

inline Row8 operator*(float s, const Row8& a) {
    return {s * a.at};
}

/// How two surfaces lie and move, `time` into the substep, as plain vectors: impacts are few and
/// branch a lot.
struct ContactSolver::Approach {
    std::uint32_t a, b;
    Vec3 normal, shift_a, shift_b, turn_a, turn_b;
    float closing;

    /// `from`: a watch, or a lane of a batch.
    template <class From>
    Approach(const From& from, const SolverBodies& bodies, float time)
        : a(from.a),
          b(from.b),
          normal(from.normal) {
        const Row8 drift_a = bodies.drift[a] + time * bodies.motion[a];
        const Row8 drift_b = bodies.drift[b] + time * bodies.motion[b];
        const Vec3 offset =
            from.lead + SolverBodies::linear(drift_b) - SolverBodies::linear(drift_a);
        closing = normal.dot(offset);
        shift_a = from.follow_b * offset;
        shift_b = shift_a - offset - from.between;
        turn_a = SolverBodies::angular(drift_a);
        turn_b = SolverBodies::angular(drift_b);
    }

    [[nodiscard]] Vec3 slip(const Motions& m, const Vec3& arm) const {
        return SolverBodies::linear(m.b) - SolverBodies::linear(m.a) +
               SolverBodies::angular(m.b).cross(arm + shift_b) -
               SolverBodies::angular(m.a).cross(arm + shift_a);
    }

    [[nodiscard]] float speed(const Motions& m, const Vec3& arm) const {
        return normal.dot(slip(m, arm));
    }

    [[nodiscard]] float rate(const Motions& m) const {
        return normal.dot(SolverBodies::angular(m.b) - SolverBodies::angular(m.a));
    }

    /// Of a point that was `separation` apart at the time of contact.
    [[nodiscard]] float gap(float separation, const Vec3& arm) const {
        return separation + closing + (arm + shift_b).cross(normal).dot(turn_b) -
               (arm + shift_a).cross(normal).dot(turn_a);
    }
};

/// The same of one lane of a batch, with the directions of its friction.
struct ContactSolver::Single : Approach {
    struct FromBatch {
        std::uint32_t a, b;
        Vec3 normal, lead, between;
        float follow_b;

        FromBatch(const ContactBatch& batch, std::size_t lane)
            : a(batch.a[lane]),
              b(batch.b[lane]),
              normal(batch.normal.get(lane)),
              lead(batch.lead.get(lane)),
              between(batch.between.get(lane)),
              follow_b(batch.follow_b[lane]) {}
    };

    Vec3 tangent1, tangent2;

    Single(const ContactBatch& batch, std::size_t lane, const SolverBodies& bodies, float time)
        : Approach(FromBatch(batch, lane), bodies, time),
          tangent1(batch.tangent.get(lane)),
          tangent2(normal.cross(tangent1)) {}
};

/// The impulses of an impact at the points of a contact and at its patch, N s and N m s.
struct ContactSolver::Blow {
    std::array<float, kMaxManifoldPoints> push{};
    std::array<float, kMaxManifoldPoints> wanted{};  ///< speeds after it, m/s
    std::array<bool, kMaxManifoldPoints> meets{};
    float shear1 = 0.0F, shear2 = 0.0F, twist = 0.0F;

    [[nodiscard]] float power(const ContactSolver& solver,
                              const SolverWatch& w,
                              const Single& at,
                              const Motions& m,
                              bool friction) const;
};

}  // namespace zoned::physics

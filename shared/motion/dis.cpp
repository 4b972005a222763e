#include "shared/motion/dis.h"

#include "shared/motion/turn_integrals.h"

namespace zoned::motion {

namespace {

/// The letters of an algorithm's name.
struct DisTraits {
    bool moves = true;
    bool turns = false;
    bool accelerates = false;
    bool body = false;
};

DisTraits traits_of(DisAlgorithm algorithm) {
    switch (algorithm) {
        case DisAlgorithm::kStatic:
            return {false, false, false, false};
        case DisAlgorithm::kFpw:
            return {true, false, false, false};
        case DisAlgorithm::kRpw:
            return {true, true, false, false};
        case DisAlgorithm::kRvw:
            return {true, true, true, false};
        case DisAlgorithm::kFvw:
            return {true, false, true, false};
        case DisAlgorithm::kFpb:
            return {true, false, false, true};
        case DisAlgorithm::kRpb:
            return {true, true, false, true};
        case DisAlgorithm::kRvb:
            return {true, true, true, true};
        case DisAlgorithm::kFvb:
            return {true, false, true, true};
    }
    return {false, false, false, false};
}

/// (diagonal I + skew [w]x + outer w w^T) v.
Vec3d apply(double diagonal, double skew, double outer, const Vec3d& w, const Vec3d& v) {
    return diagonal * v + skew * w.cross(v) + (outer * w.dot(v)) * w;
}

}  // namespace

DisState dis_predict(const DisState& from, DisAlgorithm algorithm, double elapsed_s) {
    const DisTraits traits = traits_of(algorithm);
    const double t = elapsed_s;
    const Vec3d w = traits.turns ? from.angular_velocity : Vec3d(Vec3d::Zero());
    const Vec3d a = traits.accelerates ? from.acceleration : Vec3d(Vec3d::Zero());
    DisState to = from;
    if (!traits.moves) {
        return to;
    }
    to.velocity = from.velocity + a * t;
    if (traits.body) {
        const TurnIntegrals i = turn_integrals(w.norm() * t);
        const Vec3d along =
            apply(t * i.sine, t * t * i.versine, t * t * t * i.arc, w, from.velocity);
        const Vec3d sped = apply(
            t * t * i.first_cosine, t * t * t * i.first_sine, t * t * t * t * i.first_rest, w, a);
        to.position = from.position + from.orientation * Vec3d(along + sped);
    } else {
        to.position = from.position + (from.velocity + 0.5 * t * a) * t;
    }
    // In body axes the turn comes after what was: q exp(w t / 2).
    const double half = 0.5 * w.norm() * t;
    const Vec3d part = (0.5 * t * turn_integrals(half).sine) * w;
    to.orientation =
        from.orientation * Eigen::Quaterniond(std::cos(half), part.x(), part.y(), part.z());
    return to;
}

}  // namespace zoned::motion

// Moves of a soft body as a whole: pushed, placed, handed on; and how it is turned.
#include "server/physics/shapes/ranges.h"
#include "server/physics/soft/soft_impl.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::physics::soft {

namespace {

/// A turn of less than this ends the search, rad.
constexpr double kSameTurn = 1.0e-6;
constexpr int kMostTurns = 32;

/// Sum of m x q^T about the centres of mass.
Eigen::Matrix3d moments_of(const SoftBody& body, const SoftDef& rest) {
    double mass = 0.0;
    Vec3d now = Vec3d::Zero();
    Vec3d then = Vec3d::Zero();
    const std::size_t count = std::min(rest.nodes.size(), body.x.size());
    for (std::size_t i = 0; i < count; ++i) {
        const auto m = static_cast<double>(rest.nodes[i].mass);
        mass += m;
        now += m * body.position(i).cast<double>();
        then += m * rest.nodes[i].position.cast<double>();
    }
    now /= mass;
    then /= mass;
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3d x = body.position(i).cast<double>() - now;
        const Vec3d q = rest.nodes[i].position.cast<double>() - then;
        sum += static_cast<double>(rest.nodes[i].mass) * x * q.transpose();
    }
    return sum;
}

}  // namespace

SoftParcel::SoftParcel() = default;
SoftParcel::SoftParcel(SoftParcel&&) noexcept = default;
SoftParcel& SoftParcel::operator=(SoftParcel&&) noexcept = default;
SoftParcel::~SoftParcel() = default;

#define ZONED_SOFT_BODY(id)                                      \
    ZONED_ASSERT(contains(id), "a soft body that is not there"); \
    SoftBody& body = impl_->bodies[(id).value - 1 - retired_]

void SoftBodies::sleep(SoftId id) {
    ZONED_SOFT_BODY(id);
    body.asleep = true;
    std::fill(body.v.begin(), body.v.end(), Row4::Zero());
}

void SoftBodies::push(SoftId id, const Vec3& change) {
    ZONED_SOFT_BODY(id);
    if (!fit_velocity(change, Vec3::Zero())) {
        return;
    }
    for (std::size_t i = 0; i < body.x.size(); ++i) {
        if (body.x[i].w() > 0.0F) {
            body.v[i].head<3>() += change;
        }
    }
    wake(id);
}

void SoftBodies::place(SoftId id, const Vec3& position, const Quat& turn) {
    ZONED_SOFT_BODY(id);
    if (!fit_position(position) || !fit_orientation(turn)) {
        return;
    }
    impl_->wake_around(body);
    place_rigid(body, rigid_hull_of(body), position, turn, Vec3::Zero(), Vec3::Zero());
    fit_box(body);
    wake(id);
}

core::Result<BodyDef> SoftBodies::rigid_body(SoftId id) const {
    ZONED_SOFT_BODY(id);
    return rigid_body_of(body);
}

bool SoftBodies::rigid(SoftId id) const {
    ZONED_SOFT_BODY(id);
    return body.rigid;
}

bool SoftBodies::touches_bodies(SoftId id) const {
    ZONED_SOFT_BODY(id);
    return body.touches_dynamic;
}

SoftParcel SoftBodies::take(SoftId id) {
    ZONED_SOFT_BODY(id);
    SoftParcel parcel;
    parcel.body_ = std::make_unique<SoftBody>(std::move(body));
    // The bodies that it met stay behind.
    parcel.body_->contacts.clear();
    parcel.body_->neighbours.clear();
    remove(id);
    return parcel;
}

SoftId SoftBodies::give(SoftParcel parcel, const Vec3& shift) {
    ZONED_ASSERT(!parcel.empty(), "a parcel holds a body");
    if (impl_ == nullptr) {
        impl_ = std::make_unique<Impl>();
    }
    SoftBody& body = impl_->bodies.emplace_back(std::move(*parcel.body_));
    body.there = true;
    for (Row4& x : body.x) {
        x.head<3>() += shift;
    }
    body.start = body.kept = body.predicted = body.x;
    fit_box(body);
    return SoftId(retired_ + static_cast<std::uint32_t>(impl_->bodies.size()));
}

/// Matthias Mueller, Jan Bender, Nuttapong Chentanez, Miles Macklin, A Robust Method to Extract the
/// Rotational Part of Deformations, MIG 2016, algorithm 1; each turn as a quaternion (1, w / 2)
/// made unit, which has the same fixed point and needs no sine.
Quat SoftBodies::best_fit_turn(SoftId id, const SoftDef& rest, const Quat& guess) const {
    ZONED_SOFT_BODY(id);
    const Eigen::Matrix3d a = moments_of(body, rest);
    const double least = 1.0e-9 * a.cwiseAbs().maxCoeff();
    Eigen::Quaterniond q = guess.cast<double>().normalized();
    for (int i = 0; i < kMostTurns && least > 0.0; ++i) {
        const Eigen::Matrix3d r = q.toRotationMatrix();
        Vec3d w = Vec3d::Zero();
        double along = 0.0;
        for (int k = 0; k < 3; ++k) {
            w += r.col(k).cross(a.col(k));
            along += r.col(k).dot(a.col(k));
        }
        w /= std::abs(along) + least;
        if (w.norm() < kSameTurn) {
            break;
        }
        q = (Eigen::Quaterniond(1.0, 0.5 * w.x(), 0.5 * w.y(), 0.5 * w.z()) * q).normalized();
    }
    return Quat(q.cast<float>()).normalized();
}

#undef ZONED_SOFT_BODY

}  // namespace zoned::physics::soft

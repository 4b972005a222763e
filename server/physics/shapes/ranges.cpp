#include "server/physics/shapes/ranges.h"

namespace zoned::physics {

bool fit_position(const Vec3& position) {
    return (position.array().abs() <= kMaxCoordinate).all();
}

bool fit_velocity(const Vec3& velocity, const Vec3& angular_velocity) {
    return velocity.squaredNorm() <= kMaxSpeed * kMaxSpeed &&
           angular_velocity.squaredNorm() <= kMaxSpin * kMaxSpin;
}

bool fit_force(const Vec3& force, const Vec3& torque) {
    return (force.array().abs() <= kMaxForce).all() && (torque.array().abs() <= kMaxForce).all();
}

bool fit_motor(float speed, float most) {
    return within(most, 0.0F, kMaxForce) && within(speed, -kMaxSpeed, kMaxSpeed);
}

bool fit_orientation(const Quat& orientation) {
    return within(orientation.coeffs().norm(), 0.99F, 1.01F);
}

}  // namespace zoned::physics
